"""What the README and the documentation show is what happens."""

from __future__ import annotations

import re

import pytest

from .pages import OTHERS, ROOT, read_blocks, read_commands, run_page

PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_everything_that_a_page_shows_runs_and_prints_what_it_says(page, tmp_path, monkeypatch):
    run_page(page, tmp_path, monkeypatch)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_every_link_and_picture_of_a_page_is_in_the_repository(page):
    prose = re.sub(r"^```.*?^```", "", page.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL)
    for target in re.findall(r"\]\(([^)\s]+)\)|<img src=\"([^\"]+)\"", prose):
        link = "".join(target).partition("#")[0]
        if link and not re.match(r"[a-z]+:", link):
            assert (page.parent / link).exists(), f"{page.name} links to {link}, which is not there"


def test_the_readme_gives_two_commands_one_for_the_main_job_and_one_for_the_tests():
    blocks = [block for block in read_blocks(ROOT / "README.md") if block.language == "sh"]
    assert len(blocks) >= 2
    main, tests = ([command.text for command in read_commands(block)] for block in blocks[:2])
    for commands in (main, tests):
        assert commands[0].startswith("python -m pip install -c constraints.txt ")
    assert any("ppinfer infer data/" in text for text in main)
    assert any(text.split(" && ")[-1].startswith("python -m pytest") for text in tests)


def test_the_readme_opens_with_what_it_does_a_figure_and_then_the_commands():
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    title, figure, command = text.index("# ppinfer"), text.index("docs/figures/"), text.index("```sh")
    assert title < figure < command
    assert text[title:figure].strip().count("\n") >= 1


def test_other_programs_are_named_once_so_that_a_typo_in_a_page_is_found():
    assert not any(name.startswith(("ppinfer", "ppsim")) for name in OTHERS)


def test_the_figure_of_the_readme_is_what_its_first_command_draws(tmp_path, monkeypatch):
    from matplotlib.image import imread

    run_page(ROOT / "README.md", tmp_path, monkeypatch)
    shown, drawn = imread(ROOT / "docs/figures/reaching-small.png"), imread("report/figures/trial-1.png")
    # fonts may be rasterised a little differently elsewhere; the curves and points may not move
    same = shown.shape == drawn.shape and abs(shown - drawn).mean() < 0.005
    assert same, (
        "run the README's first command, then: cp report/figures/trial-1.png docs/figures/reaching-small.png"
    )
