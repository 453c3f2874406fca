"""The methods that the paper cites, made again in their simplest form, to be measured beside AIM.

They are no part of the library's core and nobody should embed with them; `table.compare` shows why.
"""
