"""Docstrings as reStructuredText: they are plain text with `names` in it, examples, and indented code."""

import re

SPECIAL = re.compile(r"`([^`]+)`|[\\*|]|(?<=\w)_(?!\w)")


def mark(_app, _what, _name, _object, _options, lines):
    """Sphinx asks for it for each docstring, and takes what `lines` then holds."""
    out, in_example = [], False
    for line in lines:
        in_example = line.lstrip().startswith(">>> ") or in_example and bool(line.strip())
        if line.startswith("    ") and not in_example and (not out or not out[-1].strip()):
            out += ["::", ""]
        out.append(line if in_example or line.startswith("    ") else SPECIAL.sub(marked, line))
    lines[:] = out


def marked(found):
    """A name as code, and what reStructuredText would take for a mark as it is written."""
    return f"``{found[1]}``" if found[1] else f"\\{found[0]}"
