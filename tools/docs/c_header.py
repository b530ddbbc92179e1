"""A public header as a page: its comments as prose, its functions and types as entries of Sphinx's C domain.

The headers' comments are plain ones, before what they speak of and behind members, so that what reads Doxygen's marks
(breathe, hawkmoth) sees none of them.
"""

import itertools
import re
import textwrap
from dataclasses import dataclass, field
from pathlib import Path

COMMENT = re.compile(r"/\*.*?\*/", re.DOTALL)
GUARDS = re.compile(r'^#ifdef __cplusplus\n[^#]*^#endif\n|^#(?:ifndef|define) TALUS_\w+_H\n|^#include [<"].*\n|^#endif\n?\Z', re.MULTILINE)
FUNCTION = re.compile(r"(?:TL_CHECK )?(\w[\w\s*]*?\b(tl_\w+)\([^{};]*\));")
TYPE = re.compile(r"typedef (struct|enum) (\w+)")
CALLED_TYPE = re.compile(r"typedef ([\w\s*]+\(\*(\w+)\)\(.*\));", re.DOTALL)
INCLUDE = Path(__file__).resolve().parents[2] / "include"


@dataclass
class Item:
    """What a comment speaks of: the declarations behind it, until a blank line or the next comment."""

    comment: str = ""
    declarations: list[str] = field(default_factory=list)


def page(text):
    """MyST of a header's text."""
    first = COMMENT.match(text)
    title, _, rest = plain(first[0]).partition("\n")
    name, _, about = title.partition(": ")
    body = "\n\n".join(entry(item) for item in items(GUARDS.sub("", text[first.end() :] + "\n")))
    return f"# {name}\n\n{prose(about[:1].upper() + about[1:])}\n\n{prose(rest, 'c')}\n\n{body}\n"


# ---- what stands in a header ---------------------------------------------------------------


def plain(comment):
    """A comment's text without its stars."""
    lines = [line.removeprefix(" *").removeprefix(" ") for line in comment[2:-2].removeprefix(" ").rstrip().split("\n")]
    return "\n".join(line.rstrip() for line in lines)


def items(text):
    """The Items below a header's first comment, in order."""
    out, fresh = [Item()], True
    at = 0
    while at < len(text):
        if text[at] == "\n":
            fresh = fresh or text[at - 1 : at + 1] == "\n\n"
            at += 1
            continue
        end = comment_end(text, at) or declaration_end(text, at)
        if fresh or comment_end(text, at):
            out.append(Item())
        if comment_end(text, at):
            out[-1].comment = text[at:end]
        else:
            out[-1].declarations.append(text[at:end])
        at, fresh = end, False
    return [item for item in out if item.comment or item.declarations]


def comment_end(text, at):
    found = COMMENT.match(text, at)
    return found.end() if found else None


def declaration_end(text, at):
    """The end of the line that ends a declaration: of a macro, or with a semicolon outside of all brackets."""
    if text[at] == "#":
        conditional = re.compile(r"#if.*?^#endif", re.DOTALL | re.MULTILINE).match(text, at)
        return conditional.end() if conditional else re.compile(r"(?:.*\\\n)*.*").match(text, at).end()
    for line in re.finditer(r"$", text[at:], re.MULTILINE):
        code = COMMENT.sub("", text[at : at + line.start()])
        closed = all(code.count(a) == code.count(b) for a, b in ("{}", "()")) and "/*" not in code
        if closed and re.search(r";\s*\Z|\A[A-Z_]+\(.*\)\Z", code):
            return at + line.start()
    raise ValueError(f"no end of {text[at : at + 60]!r}")


# ---- as pages ------------------------------------------------------------------------------


def entry(item):
    """An Item's MyST. A rule with words in it is a heading."""
    heading = re.fullmatch(r"/\* -+ (.*?) -+ \*/", item.comment)
    if heading:
        return f"## {heading[1][:1].upper()}{heading[1][1:]}\n\n" + entry(Item("", item.declarations)) * bool(item.declarations)
    about = prose(plain(item.comment)) if item.comment else ""
    signatures = [FUNCTION.fullmatch(COMMENT.sub("", text).strip()) for text in item.declarations]
    if signatures and all(signatures):
        return directive("function", [found[1] for found in signatures], about)
    if len(item.declarations) == 1 and (found := TYPE.match(item.declarations[0])):
        return directive(found[1], [found[2]], f"{about}\n\n{code(item)}")
    if len(item.declarations) == 1 and (found := CALLED_TYPE.fullmatch(item.declarations[0])):
        return directive("type", [found[1]], about)
    if len(item.declarations) > 1 and any(TYPE.match(text) for text in item.declarations):
        return "\n\n".join([entry(Item(item.comment, item.declarations[:1])), *(entry(Item("", [text])) for text in item.declarations[1:])])
    return f"{about}\n\n{code(item)}" if item.declarations else about


def directive(kind, signatures, body):
    """Signatures, one below the other, and what is said of them all."""
    lines = [re.sub(r"\s+", " ", signature).strip() for signature in signatures]
    bodies = [""] * (len(lines) - 1) + [body]
    return "\n\n".join(f"````{{c:{kind}}} {line}\n\n{body}\n````" for line, body in zip(lines, bodies, strict=True))


def code(item):
    return "```c\n" + "\n".join(item.declarations) + "\n```"


def prose(text, language="text"):
    """Paragraphs; what is indented stands as it is."""
    out = []
    for part in re.split(r"\n\s*\n", text.strip("\n")):
        for indented, lines in itertools.groupby(part.split("\n"), lambda line: line.startswith("  ")):
            lines = list(lines)
            out.append(f"```{language}\n{textwrap.dedent(chr(10).join(lines))}\n```" if indented else marked(" ".join(lines)))
    return "\n\n".join(out)


def marked(text):
    """Text as MyST: identifiers as code, the library's functions and pages as links, all else as it is written."""
    return re.sub(r"`[^`]+`|\bdocs/\w+\.md\b|\b[tT][lL]_\w+|[\\`*_{}\[\]<>#|~$&!^]", lambda found: word(found[0]), text)


def word(text):
    if len(text) == 1:
        return f"\\{text}"
    if text.startswith("docs/"):
        return f"[{text}](/{text})"
    return f"{{c:func}}`{text}`" if text in functions() else text if text.startswith("`") else f"`{text}`"


def functions():
    """The names of all public functions."""
    if not functions.names:
        for path in INCLUDE.rglob("*.h"):
            functions.names |= {found[2] for found in FUNCTION.finditer(COMMENT.sub("", path.read_text()))}
    return functions.names


functions.names = set()
