import os

import h5netcdf
import numpy as np
import pytest
import xarray as xr

from ppinfer.errors import LogError
from ppinfer.studies.posterior import (
    PosteriorWriter,
    check_posterior,
    open_posterior,
    rows,
    verify_posterior,
    write_posterior,
)

from .posteriors import make_posterior


@pytest.mark.parametrize("moving_goals", [False, True])
@pytest.mark.parametrize("outliers", [False, True])
@pytest.mark.parametrize("segments_per_trial", [0, 2])
def test_a_written_posterior_reads_back_the_same(tmp_path, moving_goals, outliers, segments_per_trial):
    posterior = make_posterior(
        moving_goals=moving_goals, outliers=outliers, segments_per_trial=segments_per_trial
    )
    write_posterior(posterior, tmp_path / "post.nc")
    with open_posterior(tmp_path / "post.nc", verify=True) as read:
        assert set(read.variables) == set(posterior.variables)
        for name, expected in posterior.variables.items():
            assert read[name].dims == expected.dims
            np.testing.assert_array_equal(read[name].values.astype(expected.dtype), expected.values)
        assert posterior.attrs.items() <= read.attrs.items()
    assert os.listdir(tmp_path) == ["post.nc"]


@pytest.mark.parametrize("block", [1, 7, 64, 1000])
def test_blocks_of_any_size_make_the_same_content(tmp_path, block):
    posterior = make_posterior()
    write_posterior(posterior, tmp_path / "whole.nc")
    _write_in_blocks(posterior, tmp_path / "blocks.nc", block)
    with open_posterior(tmp_path / "whole.nc") as whole, open_posterior(tmp_path / "blocks.nc") as blocks:
        assert whole.attrs["content_sha256"] == blocks.attrs["content_sha256"]
        verify_posterior(blocks)


def test_a_failure_while_writing_leaves_nothing_and_keeps_the_old_file(tmp_path):
    write_posterior(make_posterior(), tmp_path / "post.nc")
    before = (tmp_path / "post.nc").read_bytes()
    with pytest.raises(KeyboardInterrupt), _writer(tmp_path / "post.nc", make_posterior()):
        raise KeyboardInterrupt
    assert os.listdir(tmp_path) == ["post.nc"]
    assert (tmp_path / "post.nc").read_bytes() == before


def test_leaving_with_samples_missing_is_refused_and_leaves_nothing(tmp_path):
    posterior = make_posterior()
    with pytest.raises(LogError, match="0 of n_samples=115 samples"), _writer(tmp_path / "p.nc", posterior):
        pass
    assert os.listdir(tmp_path) == []


def test_blocks_out_of_order_are_refused(tmp_path):
    posterior = make_posterior()
    with (
        pytest.raises(LogError, match="expected start=0, got 5"),
        _writer(tmp_path / "p.nc", posterior) as out,
    ):
        out.write_samples(5, **_block(posterior, 5, 10))


def test_a_nan_posterior_is_refused_naming_the_sample(tmp_path):
    posterior = make_posterior()
    posterior["log_posterior"].values[17, 1] = np.nan
    with pytest.raises(LogError, match="log_posterior of sample 17 is"):
        write_posterior(posterior, tmp_path / "p.nc")
    assert os.listdir(tmp_path) == []


def test_absent_goals_keep_their_minus_infinity(tmp_path):
    posterior = make_posterior(goals=("a", "b"))
    posterior["log_posterior"].values[:] = [0.0, -np.inf]
    write_posterior(posterior, tmp_path / "p.nc")
    with open_posterior(tmp_path / "p.nc", verify=True) as read:
        assert (read["log_posterior"].values == [0.0, -np.inf]).all()


def test_wrong_shapes_name_the_variable_and_both_shapes(tmp_path):
    posterior = make_posterior()
    block = _block(posterior, 0, 10)
    block["position"] = block["position"][:, :1]
    with (
        pytest.raises(LogError, match=r"position\(sample, space\) has shape \(10, 1\); expected \(10, 2\)"),
        _writer(tmp_path / "p.nc", posterior) as out,
    ):
        out.write_samples(0, **block)


def test_segments_outside_their_trial_are_refused(tmp_path):
    posterior = make_posterior()
    posterior["segment_stop"].values[1] = 31
    with pytest.raises(LogError, match=r"segment 1: samples \[15, 31\) do not lie in trial 0 of 30 samples"):
        write_posterior(posterior, tmp_path / "p.nc")


def test_attributes_other_than_text_and_numbers_are_refused(tmp_path):
    posterior = make_posterior()
    posterior.attrs["configuration"] = {"a": 1}
    with pytest.raises(LogError, match="'configuration' is of type dict"):
        write_posterior(posterior, tmp_path / "p.nc")


def test_a_missing_directory_is_named(tmp_path):
    with pytest.raises(LogError, match="there is no folder"):
        write_posterior(make_posterior(), tmp_path / "nowhere" / "p.nc")


def test_a_large_configuration_survives(tmp_path):
    posterior = make_posterior()
    posterior.attrs["configuration"] = "é" * 200_000
    write_posterior(posterior, tmp_path / "p.nc")
    with open_posterior(tmp_path / "p.nc", verify=True) as read:
        assert read.attrs["configuration"] == "é" * 200_000


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda path: None, "no such file"),
        (lambda path: path.mkdir(), "is a folder"),
        (lambda path: path.write_text("a,b\n1,2\n"), "is not a NetCDF4 file"),
        (lambda path: path.write_bytes(b""), "the file is empty"),
        (lambda path: xr.Dataset().to_netcdf(path, engine="h5netcdf"), "is not a posterior file"),
        (lambda path: _study_log(path), "ppinfer_format is 'study-log'"),
    ],
)
def test_what_is_no_posterior_is_refused_by_name(tmp_path, make, message):
    make(tmp_path / "odd.nc")
    with pytest.raises(LogError, match=rf"odd\.nc: .*{message}"):
        open_posterior(tmp_path / "odd.nc")


def test_a_truncated_posterior_is_refused(tmp_path):
    write_posterior(make_posterior(), tmp_path / "p.nc")
    whole = (tmp_path / "p.nc").read_bytes()
    (tmp_path / "p.nc").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(LogError, match=r"p\.nc: "):
        open_posterior(tmp_path / "p.nc", verify=True)


def test_a_flipped_bit_in_the_samples_is_found(tmp_path):
    posterior = make_posterior()
    write_posterior(posterior, tmp_path / "p.nc")
    content = bytearray((tmp_path / "p.nc").read_bytes())
    needle = posterior["log_posterior"].values[3].tobytes()
    content[content.index(needle)] ^= 1
    (tmp_path / "p.nc").write_bytes(content)
    with pytest.raises(LogError, match="truncated or damaged: infer it anew"):
        open_posterior(tmp_path / "p.nc", verify=True)


def test_a_changed_label_is_found_by_the_digest(tmp_path):
    write_posterior(make_posterior(), tmp_path / "p.nc")
    with h5netcdf.File(tmp_path / "p.nc", "a") as file:
        file["participant"][0] = "p9"
    with (
        open_posterior(tmp_path / "p.nc") as read,
        pytest.raises(LogError, match="does not match its digest"),
    ):
        verify_posterior(read, name="p.nc")


def test_missing_variables_and_wrong_types_are_reported_together():
    posterior = make_posterior().drop_vars(["time", "true_goal"])
    posterior["observed"] = posterior["observed"].astype(float)
    with pytest.raises(LogError) as caught:
        check_posterior(posterior, name="p.nc")
    for part in ("time is missing", "true_goal is missing", "observed is of type float64; int8 expected"):
        assert part in str(caught.value)


def test_verification_names_the_sample_that_does_not_sum_to_one():
    posterior = make_posterior()
    posterior["log_posterior"].values[42] = np.log(0.1)
    with pytest.raises(LogError, match="log_posterior of sample 42"):
        verify_posterior(posterior)


def test_chosen_rows_are_the_same_whatever_the_block():
    rng = np.random.default_rng(0)
    values = xr.DataArray(rng.normal(size=(100, 3)))
    index = rng.integers(0, 100, size=40)
    for block_samples in (1, 3, 10, 1000):
        np.testing.assert_array_equal(rows(values, index, block_samples=block_samples), values.values[index])
    assert rows(values, np.array([], dtype=int)).shape == (0, 3)


def _block(posterior, start, stop):
    names = ["time", "position", "observed", "log_posterior"]
    return {name: posterior[name].values[start:stop] for name in names}


def _writer(path, posterior):
    return PosteriorWriter(
        path,
        n_samples=posterior.sizes["sample"],
        goals=list(posterior["goal"].values),
        space=["x", "y"],
        goal_position_dims="trial",
        attrs={key: value for key, value in posterior.attrs.items() if not key.startswith("ppinfer_format")},
        has_outliers=False,
    )


def _write_in_blocks(posterior, path, block):
    with _writer(path, posterior) as out:
        for start in range(0, posterior.sizes["sample"], block):
            out.write_samples(start, **_block(posterior, start, start + block))
        out.write_segments(
            trial=posterior["segment_trial"].values,
            start=posterior["segment_start"].values,
            stop=posterior["segment_stop"].values,
            true_goal=posterior["true_goal"].values,
        )
        out.write_trials(
            trial_id=posterior["trial_id"].values,
            row_size=posterior["row_size"].values,
            participant=posterior["participant"].values,
            goal_position=posterior["goal_position"].values,
            goal_present=posterior["goal_present"].values,
        )


def _study_log(path):
    xr.Dataset(attrs={"ppinfer_format": "study-log"}).to_netcdf(path, engine="h5netcdf")
