"""Tables: lists of dictionaries that print well."""

from __future__ import annotations

import html
from typing import Any


class Table(list[dict[str, Any]]):
    """A list of rows, each a dictionary; ``pandas.DataFrame(table)`` is the same table."""

    @property
    def columns(self) -> list[str]:
        """The names of all columns."""
        return list(dict.fromkeys(name for row in self for name in row))

    def sorted(self, column: str) -> Table:
        """The rows by a column, the least first; rows without a value last."""
        last = float("inf")
        return Table(sorted(self, key=lambda row: last if row.get(column) is None else row[column]))

    def _texts(self) -> list[list[str]]:
        return [[_text(row.get(name)) for name in self.columns] for row in self]

    def __repr__(self) -> str:
        if not self:
            return "an empty table"
        rows = [self.columns, *self._texts()]
        widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
        numeric = [
            any(isinstance(row.get(name), (int, float)) for row in self) for name in self.columns
        ]
        lines = []
        for row in rows:
            cells = zip(row, widths, numeric)
            lines.append("  ".join(t.rjust(w) if n else t.ljust(w) for t, w, n in cells).rstrip())
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        def line(cells: list[str], tag: str) -> str:
            return "<tr>" + "".join(f"<{tag}>{html.escape(c)}</{tag}>" for c in cells) + "</tr>"

        body = "".join(line(row, "td") for row in self._texts())
        return f"<table><thead>{line(self.columns, 'th')}</thead><tbody>{body}</tbody></table>"


def _text(value: Any) -> str:
    if value is None:
        return ""
    if isinstance(value, float):
        return f"{value:.3g}"
    return str(value)
