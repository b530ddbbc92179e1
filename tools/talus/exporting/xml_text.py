"""XML as text that reads well: numbers in the fewest digits that give them back."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from typing import Any


def number(x: float) -> str:
    return repr(float(x) + 0.0).removesuffix(".0")  # and no -0


def numbers(*values: float) -> str:
    return " ".join(map(number, values))


def add(parent: ET.Element, tag: str, text: str | float | None = None, **attributes: Any) -> ET.Element:
    """A child element; attributes are text, or numbers or tuples of them. `class_` stands for class."""
    element = ET.SubElement(parent, tag)
    for name, value in attributes.items():
        element.set(name.rstrip("_"), value if isinstance(value, str) else numbers(*value) if isinstance(value, tuple) else number(value))
    if text is not None:
        element.text = text if isinstance(text, str) else number(text)
    return element


def to_text(root: ET.Element, comment: str) -> str:
    ET.indent(root)
    return f'<?xml version="1.0"?>\n<!-- {comment.replace("--", "- -")} -->\n{ET.tostring(root, encoding="unicode")}\n'
