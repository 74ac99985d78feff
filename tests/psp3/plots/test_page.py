"""Pages: every text is escaped, and nothing comes from elsewhere."""

from __future__ import annotations

from psp3.plots.page import STYLE, drawing, page, table

HOSTILE = "</title><script>1</script>'\""


def test_texts_are_escaped_wherever_they_stand() -> None:
    text = page(HOSTILE, table("here", HOSTILE, [HOSTILE], [[HOSTILE]], HOSTILE))
    text += drawing(b"<svg/>", HOSTILE, HOSTILE)
    assert "<script" not in text
    # The heading of a column is said in each of its cells, too.
    assert text.count("&lt;script&gt;") == 2 + 5 + 3
    assert "'\"" not in text


def test_cells_keep_numbers_with_their_units_and_intervals() -> None:
    text = table("here", "", [""], [["0.4 (0.2 to 0.7), 30 % diverged"], [" 1.0  2.0"]], "")
    unbroken = "0.4 (0.2~to~0.7), 30~% diverged".replace("~", "\N{NO-BREAK SPACE}")
    assert f'<td data-heading="">{unbroken}</td>' in text
    assert '<td class="numbers" data-heading=""> 1.0  2.0</td>' in text


def test_a_page_needs_nothing_else() -> None:
    text = page("Title", "")
    assert STYLE in text
    assert "url(" not in text
    assert "src=" not in text
