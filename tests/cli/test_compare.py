import numpy as np
import pytest

from ppinfer.studies.posterior import write_posterior

from ..studies.posteriors import make_posterior
from .commands import checked_json, run_one


@pytest.fixture
def posts(tmp_path):
    paths = []
    for i, factor in enumerate((1.0, 0.5, 2.0)):
        posterior = make_posterior()
        logits = posterior["log_posterior"].values * factor
        posterior["log_posterior"].values[:] = logits - np.log(np.exp(logits).sum(axis=1, keepdims=True))
        paths.append(tmp_path / f"post{i}.nc")
        write_posterior(posterior, paths[-1])
    return paths


def test_json_compares_every_later_posterior_with_the_first(posts, capsys):
    assert run_one("compare", *posts, "--at", "0.25", "0.5", "--seed", 3, "--resamples", 200, "--json") == 0
    printed = checked_json("compare", capsys.readouterr().out)
    assert len(printed["scores"]) == 6
    assert [(row["name"], row["at"]) for row in printed["differences"]] == [
        (str(path), at) for path in posts[1:] for at in (0.25, 0.5)
    ]
    assert {row["against"] for row in printed["differences"]} == {str(posts[0])}
    # scaling all logits leaves the most probable goal alone
    assert {row["accuracy"] for row in printed["differences"]} == {0.0}


def test_tables_show_intervals(posts, capsys):
    assert run_one("compare", *posts[:2], "--min-samples", 13, "--resamples", 100) == 0
    out = capsys.readouterr().out
    assert "scores on the same" in out
    assert "differences from post0.nc (95 % interval over participants)" in out
    assert "left out" in out


def test_posteriors_of_other_segments_are_refused_or_cut_to_the_common_ones(posts, tmp_path, capsys):
    write_posterior(make_posterior().isel(segment=slice(0, 6)), tmp_path / "short.nc")
    assert run_one("compare", posts[0], tmp_path / "short.nc") == 1
    assert "lacks 2 of the 8 segments" in capsys.readouterr().err
    assert run_one("compare", posts[0], tmp_path / "short.nc", "--common", "--json") == 0
    printed = checked_json("compare", capsys.readouterr().out)
    assert printed["left_out"]["not_in_every_posterior"] == 2


def test_the_same_file_twice_is_refused(posts, capsys):
    assert run_one("compare", posts[0], posts[0]) == 1
    assert "is given 2 times" in capsys.readouterr().err


def test_one_file_is_a_usage_error(posts, capsys):
    with pytest.raises(SystemExit) as caught:
        run_one("compare", posts[0])
    assert caught.value.code == 2
    assert "POST2.nc" in capsys.readouterr().err
