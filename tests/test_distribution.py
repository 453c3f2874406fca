"""Versions, dependencies and Pythons are the same everywhere, and what workflows name exists."""

import importlib.util
import json
import re
import tomllib

import pytest
from packaging.requirements import Requirement
from packaging.version import Version

import isoembed
from places import ROOT

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
EXTRAS = PROJECT["optional-dependencies"]
WORKFLOWS = sorted((ROOT / ".github" / "workflows").glob("*.yml"))


def text(name):
    return (ROOT / name).read_text(encoding="utf-8")


def floors(requirements):
    """The lowest version of each package; none has any other condition."""
    found = {}
    for requirement in map(Requirement, requirements):
        (condition,) = requirement.specifier
        assert condition.operator == ">=" and requirement.url is None
        found[requirement.name] = Version(condition.version)
    return found


def test_the_lowest_versions_are_those_that_are_tested():
    pins = [line for line in text("constraints/lowest.txt").splitlines() if not line.startswith("#")]
    tested = {name: Version(version) for name, version in (pin.split("==") for pin in pins)}
    assert tested == floors(PROJECT["dependencies"] + EXTRAS["test"])


def test_extras_agree_with_one_another():
    lowest = floors(PROJECT["dependencies"])
    for requirements in EXTRAS.values():
        for requirement in map(Requirement, requirements):
            bounds = [Version(condition.version) for condition in requirement.specifier]
            assert lowest.setdefault(requirement.name, bounds) == bounds, requirement.name


def test_the_recipe_asks_for_what_the_package_asks_for():
    recipe = text("conda/recipe.yaml")
    run = re.search(r"^  run:\n((?:    - .*\n)+)", recipe, re.MULTILINE)[1]
    listed = [line.removeprefix("    - ").replace(" ", "") for line in run.splitlines()]
    assert listed.pop(0) == "python>=${{python_min}}"
    assert floors(listed) == floors(PROJECT["dependencies"])
    context = dict(re.findall(r'^  (\w+): "(.*)"$', recipe, re.MULTILINE))
    assert f">={context['python_min']}" == PROJECT["requires-python"]
    assert context["version"] == released()[0][0]
    for name, target in PROJECT["scripts"].items():
        assert f"- {name} = {target}\n" in recipe


def released():
    """Versions and dates in the changelog, the last first."""
    return re.findall(r"^## \[(\d+\.\d+\.\d+)\] - (\d{4}-\d\d-\d\d)$", text("CHANGELOG.md"), re.MULTILINE)


def test_one_version_and_one_date_are_the_last_release():
    citation = dict(re.findall(r"^(version|date-released): (\S+)$", text("CITATION.cff"), re.MULTILINE))
    assert released()[0] == (citation["version"], citation["date-released"])
    assert f"version = {{{citation['version']}}}" in text("docs/citing.md")
    versions = [Version(version) for version, _ in released()]
    assert versions == sorted(versions, reverse=True)


def test_the_version_is_a_release_or_in_development_after_it():
    last, version = Version(released()[0][0]), Version(isoembed.__version__)
    unreleased = re.search(r"^## \[Unreleased\]\n+###", text("CHANGELOG.md"), re.MULTILINE)
    assert version.is_devrelease and version > last if unreleased else version == last


def test_the_pythons_that_are_told_are_tested_by_workflows():
    prefix = "Programming Language :: Python :: 3."
    told = {f"3.{c.removeprefix(prefix)}" for c in PROJECT["classifiers"] if c.startswith(prefix)}
    matrix = re.search(r"python: \[(.*)\]", text(".github/workflows/tests.yml"))[1]
    assert told <= set(re.findall(r'"([\d.]+)"', matrix))
    assert f">={min(told, key=Version)}" == PROJECT["requires-python"]


def test_the_links_of_the_readme_are_whole_on_an_index():
    spec = importlib.util.spec_from_file_location("readme", ROOT / "release" / "readme.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    shown = module.whole(text("README.md"), "https://example.org/one/isoembed/", "0.2.0")
    links = re.findall(r"\]\(([^)]+)\)", shown)
    assert len(links) > 30 and all(link.startswith(("https://", "#")) for link in links)
    assert not module.relative_links(shown)
    pictures = re.findall(r"!\[[^\]]*\]\(https://example.org/one/isoembed/raw/v0.2.0/([^)]+)\)", shown)
    pages = re.findall(r"\(https://example.org/one/isoembed/blob/v0.2.0/([^)#]+)[^)]*\)", shown)
    assert len(pictures) >= 6 and len(pages) > 20
    assert all((ROOT / name).is_file() for name in pictures + pages)


def test_the_container_installs_what_exists():
    container = json.loads(text(".devcontainer/devcontainer.json"))
    (extras,) = re.findall(r"'\.\[(.*?)\]'", container["postCreateCommand"])
    assert set(extras.split(",")) <= EXTRAS.keys()
    binder = [
        Requirement(line) for line in text("binder/requirements.txt").splitlines() if line[0] not in "#.-"
    ]
    known = {
        requirement.name for requirements in EXTRAS.values() for requirement in map(Requirement, requirements)
    }
    assert {requirement.name for requirement in binder} <= known | {"ipykernel", "jupyterlab"}


@pytest.mark.parametrize("workflow", WORKFLOWS, ids=lambda path: path.stem)
def test_what_a_workflow_names_exists(workflow):
    steps = re.findall(r"^      - run: (?:>-\n((?: {10}.*\n)+)|(.*)\n)", workflow.read_text(), re.MULTILINE)
    assert steps
    for step in (" ".join((folded or line).split()) for folded, line in steps):
        assert re.match(r"python |bash |test ", step), step
        for name in re.findall(r"(?:^| )((?:tests|release|constraints|\.ci)/\S+)", step):
            assert (ROOT / name).exists(), name
        for extras in re.findall(r'"\.\[(.*?)\]"', step):
            assert set(extras.split(",")) <= EXTRAS.keys(), extras
