# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Curves as an SVG with two logarithmic axes that takes its colours from the page."""

import html
import math

_WIDTH, _HEIGHT, _LEFT, _BOTTOM, _TOP = 720, 400, 70, 46, 12
# Told apart without colour too.
_SHAPES = (
    '<circle cx="{x:.1f}" cy="{y:.1f}" r="4.5"/>',
    '<path d="M{x:.1f} {y:.1f}m-5-4h10l-5 9z"/>',
    '<path d="M{x:.1f} {y:.1f}m0-6l5 6l-5 6l-5-6z"/>',
    '<path d="M{x:.1f} {y:.1f}m-4-4h8v8h-8z"/>',
    '<path d="M{x:.1f} {y:.1f}m-5 4h10l-5-9z"/>',
)


def log_log(series: dict[str, list[tuple[float, float, str]]], x_title: str, y_title: str, floor: float = 0.0) -> str:
    """The SVG element. series: name -> (x, y, what a pointer shows), x and y above 0.

    floor: a level that is drawn as a dashed line, what lies below it being noise of the measurement; 0 for none.
    """
    points = [(x, y) for rows in series.values() for x, y, _ in rows]
    (x0, x1), (y0, y1) = (_span([p[k] for p in points] + ([floor] if k and floor else [])) for k in (0, 1))
    right = 170

    def at(x, y):
        across = (math.log10(x) - x0) / (x1 - x0)
        up = (math.log10(y) - y0) / (y1 - y0)
        return (_LEFT + across * (_WIDTH - _LEFT - right), _HEIGHT - _BOTTOM - up * (_HEIGHT - _BOTTOM - _TOP))

    parts = []
    for value in _ticks(x0, x1):
        x, _ = at(value, 10**y0)
        parts.append(f'<path class="grid" d="M{x:.1f} {_TOP}V{_HEIGHT - _BOTTOM}"/>')
        parts.append(f'<text x="{x:.1f}" y="{_HEIGHT - _BOTTOM + 17}" text-anchor="middle">{value:g}</text>')
    for value in _ticks(y0, y1):
        _, y = at(10**x0, value)
        parts.append(f'<path class="grid" d="M{_LEFT} {y:.1f}H{_WIDTH - right}"/>')
        parts.append(f'<text x="{_LEFT - 7}" y="{y + 4:.1f}" text-anchor="end">{value:g}</text>')
    if floor:
        _, y = at(10**x0, floor)
        parts.append(f'<path class="floor" d="M{_LEFT} {y:.1f}H{_WIDTH - right}"/>')
        parts.append(f'<text x="{_WIDTH - right + 8}" y="{y + 4:.1f}">reference’s noise</text>')
    for i, (name, rows) in enumerate(series.items()):
        places = [at(x, y) for x, y, _ in rows]
        shape = _SHAPES[i % len(_SHAPES)]
        line = "L".join(f"{x:.1f} {y:.1f}" for x, y in places)
        marks = "".join(
            f"<g>{shape.format(x=x, y=y)}<title>{html.escape(f'{name}: {text}')}</title></g>"
            for (x, y), (_, _, text) in zip(places, rows)
        )
        key = shape.format(x=_WIDTH - right + 16, y=_TOP + 14 + 22 * i)
        label = f'<text x="{_WIDTH - right + 28}" y="{_TOP + 18 + 22 * i}">{html.escape(name)}</text>'
        parts.append(f'<g class="curve c{i % len(_SHAPES)}"><path class="line" d="M{line}"/>{marks}{key}{label}</g>')
    middle = (_HEIGHT - _BOTTOM + _TOP) / 2
    parts.append(
        f'<text x="{(_LEFT + _WIDTH - right) / 2}" y="{_HEIGHT - 6}" text-anchor="middle">{html.escape(x_title)}</text>'
    )
    parts.append(
        f'<text transform="translate(14 {middle}) rotate(-90)" text-anchor="middle">{html.escape(y_title)}</text>'
    )
    return (
        f'<svg class="plot" viewBox="0 0 {_WIDTH} {_HEIGHT}" role="img" aria-label="{html.escape(y_title)} over '
        f'{html.escape(x_title)}">{"".join(parts)}</svg>'
    )


def _span(values):
    """Decimal logarithms of the least and the largest value, with air around them."""
    low, high = math.log10(min(values)), math.log10(max(values))
    air = max(0.08 * (high - low), 0.1)
    return low - air, high + air


def _ticks(low, high):
    """Round values within a span: powers of ten, and 2 and 5 times them where there are few."""
    steps = (1,) if high - low > 2.5 else (1, 2, 5)
    values = [s * 10.0**k for k in range(math.floor(low), math.ceil(high) + 1) for s in steps]
    return [v for v in values if low <= math.log10(v) <= high]
