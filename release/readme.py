"""README.md for the package index, which has no folder docs/: links and pictures with whole addresses."""

import re

LINK = re.compile(r"(!?)(\[[^\]]*\])\((?!https?:|mailto:|#)([^)\s]+)\)")


def relative_links(text: str) -> list[str]:
    """What the links and pictures of a page lead to in the repository.

    Parameters
    ----------
    text : str
        The page, in Markdown.
    """
    return [match[3] for match in LINK.finditer(text)]


def whole(text: str, repository: str, version: str) -> str:
    """The page with whole addresses, of the files as they are at the tag of a version.

    Parameters
    ----------
    text : str
    repository : str
        Its address, as of GitHub and Codeberg: ``https://HOST/OWNER/NAME``.
    version : str
        Without the ``v`` of the tag.
    """
    base = f"{repository.rstrip('/')}/{{}}/v{version}"

    def address(match: re.Match[str]) -> str:
        picture, label, path = match.groups()
        return f"{picture}{label}({base.format('raw' if picture else 'blob')}/{path})"

    return LINK.sub(address, text)
