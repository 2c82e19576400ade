"""Formulas of pages as MathML, which browsers show without scripts."""

from __future__ import annotations

from typing import Any

from latex2mathml.converter import convert


def setup(app: Any) -> dict[str, bool]:
    """Registers the converter."""
    from docutils.nodes import SkipNode

    def visit(self: Any, node: Any) -> None:
        self.body.append(convert(node.astext()))
        raise SkipNode

    def visit_block(self: Any, node: Any) -> None:
        self.body.append(convert(node.astext(), display="block"))
        raise SkipNode

    app.add_html_math_renderer("mathml", (visit, None), (visit_block, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
