"""Small pieces of HTML: numbers, paragraphs, tables, figures."""


def number(x, digits=3):
    """A number with some significant digits and a true minus sign; powers of ten outside 1e-4 to 1e5."""
    if x is None:
        return "–"
    if x == 0:
        return "0"
    mantissa, exponent = f"{x:.{digits - 1}e}".split("e")
    if -4 <= int(exponent) < 5:
        text = f"{x:,.{max(0, digits - 1 - int(exponent))}f}"
    else:
        text = f"{mantissa} · 10<sup>{int(exponent)}</sup>"
    return text.replace("-", "−")


def percent(x, digits=3, sign=False):
    """A percentage; `sign` writes the plus too."""
    return f"{'+' if sign and x > 0 else ''}{number(x, digits)} %"


def milli(x, digits=3):
    """A torque in Nm as mNm, without the unit."""
    return number(1e3 * x, digits)


def table(caption, head, rows, classes=""):
    """A table; `head` is a list of rows of cells, a cell is text or (text, attributes)."""

    def row(cells, tag, attributes=""):
        out = []
        for k, cell in enumerate(cells):
            text, extra = cell if isinstance(cell, tuple) else (cell, "")
            name = "th" if tag == "th" or k == 0 else "td"
            out.append(f"<{name}{' ' + extra if extra else ''}>{text}</{name}>")
        return f"<tr{attributes}>{''.join(out)}</tr>"

    body = []
    for cells in rows:
        best = isinstance(cells, dict)
        body.append(row(cells["best"] if best else cells, "td", ' class="best"' if best else ""))
    return (f'<div class="wide {classes}"><table><caption>{caption}</caption>'
            f"<thead>{''.join(row(cells, 'th') for cells in head)}</thead>"
            f"<tbody>{''.join(body)}</tbody></table></div>\n")  # fmt: skip


def figure(caption, panels, key=(), note=""):
    """Panels with one key of (role, name) for all of them."""
    entries = "".join(f'<li><i style="background: var(--{role})"></i>{name}</li>' for role, name in key)
    parts = [
        f"<figcaption>{caption}</figcaption>" if caption else "",
        f'<ul class="key">{entries}</ul>' if key else "",
        f'<div class="panels">{"".join(f"<div>{panel}</div>" for panel in panels)}</div>',
        paragraph(note, "note") if note else "",
    ]
    return f"<figure>{''.join(parts)}</figure>\n"


def section(anchor, title, *parts):
    """A section of the page."""
    return f'<section id="{anchor}"><h2>{title}</h2>\n{"".join(parts)}</section>\n'


def paragraph(text, kind="text"):
    """One paragraph; kinds with a look of their own are "lead" and "note"."""
    return f'<p class="{kind}">{text}</p>\n'
