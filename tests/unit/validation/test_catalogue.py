"""The list of experiments, and how they are named."""

from __future__ import annotations

import pytest

from contiga.errors import InputError
from contiga_validation.catalogue import CHAPTERS, chapter_title, experiments, selected


def test_keys_are_unique_and_begin_with_their_chapter() -> None:
    keys = [experiment.key for experiment in experiments()]
    assert len(set(keys)) == len(keys)
    for experiment in experiments():
        if experiment.chapter < max(CHAPTERS):
            assert experiment.key.startswith((f"{experiment.chapter}.", f"{experiment.chapter}-"))


def test_experiments_are_in_the_order_of_the_chapters() -> None:
    chapters = [experiment.chapter for experiment in experiments()]
    assert chapters == sorted(chapters)
    assert {2, 5, 7} <= set(chapters)


def test_every_experiment_says_where_and_what_the_thesis_has() -> None:
    for experiment in experiments():
        assert experiment.title
        assert experiment.where
        assert experiment.thesis, experiment.key


def test_a_section_stands_for_its_experiments() -> None:
    def keys(*only: str) -> list[str]:
        return [experiment.key for experiment in selected(only)]

    assert keys("2.4") == ["2.4-insertion", "2.4-elevation"]
    assert keys("2.4-insertion") == ["2.4-insertion"]
    assert keys("2.4", " 2.2-hull ") == ["2.2-hull", "2.4-insertion", "2.4-elevation"]
    assert {"5.2.1-grouping", "5.2.3-flat"} <= set(keys("5.2"))
    assert len(keys("2", "5")) == sum(e.chapter in (2, 5) for e in experiments())
    assert [e.key for e in selected(None)] == [e.key for e in experiments()]


@pytest.mark.parametrize("word", ["9", "5.", "5.1.", "2.4-", "2.4-insert", "", " ", "all"])
def test_a_name_that_is_none_is_told_with_those_that_are(word: str) -> None:
    with pytest.raises(InputError, match="no experiment has this name") as caught:
        selected(["2.4", word])
    assert caught.value.found == word.strip()
    assert "2.2-bases" in str(caught.value)


def test_an_empty_choice_is_an_error() -> None:
    with pytest.raises(InputError, match="no experiment"):
        selected([])


def test_what_follows_the_thesis_has_a_heading_of_its_own() -> None:
    assert chapter_title(9) == chapter_title(8) == CHAPTERS[8]
    assert chapter_title(5) == CHAPTERS[5]
