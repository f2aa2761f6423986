# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Records the demonstration as the README's moving picture, an SVG whose lines come as they came at the terminal.

    python docs/recording.py docs/demo.svg

It runs `demo` in a folder of its own, which takes some minutes; waits of more than a second are shortened.
"""

import html
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

ROOT = Path(__file__).parents[1]
COLUMNS, ROWS = 120, 30
LONGEST_WAIT, AT_THE_END = 1.0, 6.0
"""As it is shown [s]."""
BLANK = "\u00a0"
"""What a browser draws as often as it stands there."""
WIDTH, HEIGHT, MARGIN = 7.25, 17.0, 12.0
"""Of a letter, of a line, and around all [pixels]."""


def recorded(out: Path) -> Iterator[tuple[float, str]]:
    """Yield the demonstration's lines with when they came [s]."""
    command = [sys.executable, "-u", "-m", "cdp_ident", "demo", "--out", str(out)]
    with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as running:
        assert running.stdout
        for line in running.stdout:
            yield time.monotonic(), line.rstrip().replace(f"{out.parent}/", "").replace(f"{ROOT}/", "")
    if running.returncode:
        raise SystemExit("the demonstration failed")


def shown(lines: Sequence[tuple[float, str]]) -> list[tuple[float, str]]:
    """Return lines that fit in, with when they are shown [s]."""
    now, before, fitting = 0.5, lines[0][0], []
    for came, line in lines:
        now += min(came - before, LONGEST_WAIT)
        before = came
        fitting += [(now, line[place : place + COLUMNS]) for place in range(0, max(len(line), 1), COLUMNS)]
    return fitting


def svg(lines: Sequence[tuple[float, str]]) -> str:
    """Return the moving picture, which begins anew at its end."""
    last = lines[-1][0] + AT_THE_END
    again = f'dur="{last:.2f}s" repeatCount="indefinite" calcMode="discrete"'
    texts = [
        f'<text y="{MARGIN + HEIGHT * (row + 0.8):.1f}" visibility="hidden">{html.escape(line.replace(" ", BLANK))}'
        f'<animate attributeName="visibility" values="hidden;visible" keyTimes="0;{at / last:.4f}" {again}/></text>'
        for row, (at, line) in enumerate(lines)
    ]
    scrolled = [
        (0.0, 0.0),
        *((at / last, HEIGHT * (row - ROWS + 1)) for row, (at, _) in enumerate(lines) if row >= ROWS),
    ]
    up = ";".join(f"0 {-way:g}" for _, way in scrolled)
    moved = f'<animateTransform attributeName="transform" type="translate" values="{up}" ' + (
        f'keyTimes="{";".join(f"{at:.4f}" for at, _ in scrolled)}" {again}/>'
    )
    size = f'width="{COLUMNS * WIDTH + 2 * MARGIN:.0f}" height="{ROWS * HEIGHT + 2 * MARGIN:.0f}"'
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" {size} font-family="monospace" font-size="12">\n'
        f'<rect {size} rx="8" fill="#161b22"/>\n<svg {size}><g fill="#e6edf3" transform="translate(0 0)">{moved}\n'
        f'<g transform="translate({MARGIN:g} 0)">\n' + "\n".join(texts) + "\n</g></g></svg>\n</svg>\n"
    )


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        came = list(recorded(Path(folder) / "demo"))
    Path(sys.argv[1]).write_text(svg(shown(came)), encoding="utf-8")
