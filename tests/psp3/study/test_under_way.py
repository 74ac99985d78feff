"""Work comes back, waits until it is taken, and who waits for it can be woken."""

from __future__ import annotations

import threading
from concurrent.futures import ThreadPoolExecutor

from psp3.study.under_way import UnderWay


def test_what_comes_back_stays_under_way_until_it_is_taken() -> None:
    under_way: UnderWay[str, int] = UnderWay()
    with ThreadPoolExecutor(1) as pool:
        under_way.hand_out(pool, "one", int, "1")
        (future,) = under_way.finished()
    assert (under_way[future], len(under_way), future.result()) == ("one", 1, 1)
    assert under_way.take(future) == "one"
    assert len(under_way) == 0


def test_waiting_ends_with_patience_and_by_waking() -> None:
    under_way: UnderWay[str, int] = UnderWay()
    assert under_way.finished(0.0) == []
    threading.Timer(0.05, under_way.wake).start()
    assert under_way.finished() == []


def test_what_has_not_begun_is_forgotten() -> None:
    under_way: UnderWay[str, bool] = UnderWay()
    goes_on = threading.Event()
    with ThreadPoolExecutor(1) as pool:
        under_way.hand_out(pool, "begun", goes_on.wait)
        under_way.hand_out(pool, "waits", goes_on.wait)
        under_way.cancel()
        assert len(under_way) == 1
        assert under_way.finished(0.0) == [], "cancelled work does not come back"
        goes_on.set()
        (future,) = under_way.finished()
    assert under_way.take(future) == "begun"


def test_all_that_has_come_back_comes_together() -> None:
    under_way: UnderWay[int, int] = UnderWay()
    with ThreadPoolExecutor(2) as pool:
        for number in range(5):
            under_way.hand_out(pool, number, abs, number)
    assert sorted(future.result() for future in under_way.finished()) == [0, 1, 2, 3, 4]
