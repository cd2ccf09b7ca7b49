"""One self-contained HTML page: no network, light and dark, readable on a phone.

Sections hold text (always escaped), tables and zoomable plotly figures; plotly's JavaScript is
written into the page once. Figures take their colours for text and grid from the page, so they
follow the reader's light or dark setting.
"""

from __future__ import annotations

import pathlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import jinja2
import plotly.graph_objects as go
import plotly.io
import plotly.offline

_BUTTONS = 30  # px at the top of a figure for plotly's row of buttons


@dataclass(frozen=True)
class Table:
    """A table of texts; the first column is left-aligned, all others right-aligned.

    ``tones``: '', 'better' or 'worse' a row, which colours its last cell.
    """

    head: Sequence[str]
    rows: Sequence[Sequence[str]]
    tones: Sequence[str] = ()


@dataclass(frozen=True)
class Card:
    """One finding: severity (blocker, warning, note), heading, place and paragraphs."""

    severity: str
    title: str
    place: str
    text: Sequence[str]


@dataclass(frozen=True)
class Section:
    """A heading, paragraphs, an optional table, an optional figure, and findings."""

    title: str
    text: Sequence[str] = ()
    table: Table | None = None
    figure: go.Figure | None = None
    cards: Sequence[Card] = ()


def write_page(path: pathlib.Path, title: str, lead: str, sections: Sequence[Section],
               facts: Mapping[str, str] | None = None) -> None:
    """Write the page; ``facts`` are the few numbers shown large at the top."""
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader('mecanum_base', 'report'), autoescape=True,
        undefined=jinja2.StrictUndefined)
    shown = [dict(title=s.title, text=s.text, table=s.table, cards=s.cards,
                  figure=None if s.figure is None else _figure_html(s.figure, index))
             for index, s in enumerate(sections)]
    html = environment.get_template('page.html').render(
        title=title, lead=lead, facts=facts or {}, sections=shown,
        plotly=plotly.offline.get_plotlyjs() if any(s['figure'] for s in shown) else '')
    path.write_text(html, encoding='utf-8')


def _figure_html(figure: go.Figure, index: int) -> str:
    figure.update_layout(
        template='none', paper_bgcolor='rgba(0,0,0,0)', plot_bgcolor='rgba(0,0,0,0)',
        margin=dict(l=56, r=12, t=_BUTTONS, b=44), hovermode='closest',
        legend=dict(orientation='h', yref='container', yanchor='top', x=0,
                    y=1.0 - _BUTTONS / float(figure.layout.height or 450)),
        modebar=dict(bgcolor='rgba(0,0,0,0)', color='#8a95a0', activecolor='#0b7fd6'))
    options: dict[str, Any] = dict(displaylogo=False, responsive=True, scrollZoom=True)
    html: str = plotly.io.to_html(figure, include_plotlyjs=False, full_html=False,
                                  div_id=f'figure-{index}', config=options)
    return html
