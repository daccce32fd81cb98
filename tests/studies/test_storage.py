import shutil
import warnings

import h5py
import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st

from ppinfer.errors import LogError
from ppinfer.studies import (
    FaultyLogError,
    content_digest,
    file_sha256,
    iter_blocks,
    log_of_trials,
    open_log,
    read_log,
    validate_log,
    write_log,
)
from ppinfer.testing.log_strategies import studies

from .logs import plain, small_log


@pytest.mark.parametrize("suffix", [".nc", ".zarr"])
@settings(max_examples=15)
@given(study=studies())
def test_a_log_comes_back_from_disk_as_it_was(tmp_path_factory, suffix, study):
    trials, options = study
    log = log_of_trials(trials, **options, attrs={"number": 3, "share": 0.5, "empty": ""})
    path = tmp_path_factory.mktemp("log") / f"log{suffix}"
    write_log(log, path)
    back = read_log(path)
    assert plain(back).identical(plain(log))
    assert {name: back[name].attrs for name in back.variables} == {
        name: log[name].attrs for name in log.variables
    }
    assert content_digest(back) == content_digest(log) == back.attrs["content_sha256"]


def test_the_same_log_has_the_same_digest_in_netcdf_and_in_zarr(tmp_path):
    write_log(small_log(), tmp_path / "log.nc")
    write_log(small_log(), tmp_path / "log.zarr")
    with open_log(tmp_path / "log.nc") as one, open_log(tmp_path / "log.zarr") as other:
        assert one.attrs["content_sha256"] == other.attrs["content_sha256"]


@pytest.mark.parametrize("suffix", [".nc", ".zarr"])
def test_writing_replaces_an_earlier_log_and_leaves_nothing_beside_it(tmp_path, suffix):
    path = tmp_path / f"log{suffix}"
    write_log(small_log(), path)
    write_log(small_log(participant=["q", "r"]), path)
    assert read_log(path).participant.values.tolist() == ["q", "r"]
    assert [item.name for item in tmp_path.iterdir()] == [path.name]


@pytest.mark.parametrize("suffix", [".nc", ".zarr"])
def test_a_write_that_fails_leaves_the_earlier_log_and_nothing_beside_it(tmp_path, suffix, monkeypatch):
    path = tmp_path / f"log{suffix}"
    write_log(small_log(), path)
    before = file_sha256(path)

    def fail(*_args, **_options):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(xr.Dataset, "to_netcdf", fail)
    monkeypatch.setattr(xr.Dataset, "to_zarr", fail)
    with pytest.raises(LogError, match=f"log{suffix}: cannot be written: No space left on device"):
        write_log(small_log(participant=["q", "r"]), path)
    assert file_sha256(path) == before
    assert [item.name for item in tmp_path.iterdir()] == [path.name]


def test_an_unsound_log_is_not_written(tmp_path):
    with pytest.raises(FaultyLogError, match=r"0\.1 after 0\.1"):
        write_log(small_log(time=[0.0, 0.1, 0.1, 0.3, 0.0, 0.1, 0.3]), tmp_path / "log.nc")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("name", "told"),
    [("log.txt", "written as .nc"), ("nowhere/log.nc", "no folder"), ("folder.nc", "is a folder")],
)
def test_a_target_that_cannot_work_is_refused(tmp_path, name, told):
    (tmp_path / "folder.nc").mkdir()
    with pytest.raises(LogError, match=told):
        write_log(small_log(), tmp_path / name)


def test_a_folder_that_is_no_zarr_store_is_not_replaced(tmp_path):
    (tmp_path / "thesis.zarr").mkdir()
    (tmp_path / "thesis.zarr" / "chapter.txt").write_text("all of it")
    with pytest.raises(LogError, match="not replaced"):
        write_log(small_log(), tmp_path / "thesis.zarr")
    assert (tmp_path / "thesis.zarr" / "chapter.txt").read_text() == "all of it"


def test_numbers_are_compressed_and_checksummed_and_text_has_any_length(tmp_path):
    write_log(small_log(), tmp_path / "log.nc")
    with h5py.File(tmp_path / "log.nc") as file:
        for name in ("time", "position", "row_size", "goal_position", "segment_start"):
            assert file[name].fletcher32, name
            assert file[name].compression == "gzip", name
        assert h5py.check_string_dtype(file["participant"].dtype).length is None


def test_an_open_log_reads_numbers_only_when_they_are_asked_for(tmp_path):
    write_log(small_log(), tmp_path / "log.nc")
    with open_log(tmp_path / "log.nc") as log:
        assert not isinstance(log.variables["position"]._data, np.ndarray)
        assert log.position.values.shape == (7, 2, 2)


def test_a_closed_log_lets_go_of_its_file(tmp_path):
    path = tmp_path / "log.nc"
    write_log(small_log(), path)
    with open_log(path) as log:
        assert log.sizes["sample"]
    with h5py.File(path, "a") as file:
        assert "time" in file


def test_text_edited_in_a_file_is_noticed(tmp_path):
    path = tmp_path / "log.nc"
    write_log(small_log(), path)
    with h5py.File(path, "r+") as file:
        file["participant"][0] = "somebody else"
    assert {fault.kind for fault in validate_log(path).faults} == {"checksum"}
    with pytest.raises(LogError, match="does not match its checksum"):
        open_log(path, verify=True)


def test_a_lost_chunk_of_a_zarr_store_is_noticed(tmp_path):
    path = tmp_path / "log.zarr"
    write_log(small_log(), path)
    next(item for item in (path / "position" / "c").rglob("*") if item.is_file()).unlink()
    assert not validate_log(path).ok


@pytest.mark.parametrize(
    ("content", "told"),
    [(b"", "the file is empty"), (b"trial,time\n1,2\n", "is not a NetCDF4 file")],
)
def test_another_file_named_like_a_log_is_refused_in_one_line(tmp_path, content, told):
    (tmp_path / "log.nc").write_bytes(content)
    with pytest.raises(LogError, match=told):
        open_log(tmp_path / "log.nc")
    report = validate_log(tmp_path / "log.nc")
    assert [fault.kind for fault in report.faults] == ["unreadable"]


def test_a_netcdf_file_of_something_else_is_refused(tmp_path):
    xr.Dataset({"rain": ("day", [1.0])}).to_netcdf(tmp_path / "rain.nc", engine="h5netcdf")
    with pytest.raises(LogError, match="is not a study log"):
        open_log(tmp_path / "rain.nc")


def test_what_is_not_there_is_named(tmp_path):
    with pytest.raises(LogError, match="there is no such file"):
        open_log(tmp_path / "log.nc")
    with pytest.raises(LogError, match=r"folder without zarr\.json"):
        open_log(tmp_path)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A log's bytes, and the folder where they may be damaged."""
    folder = tmp_path_factory.mktemp("damage")
    write_log(small_log(variables={"score": (("trial",), [1.0, 2.0])}), folder / "log.nc")
    return folder, (folder / "log.nc").read_bytes(), plain(read_log(folder / "log.nc"))


@settings(max_examples=150)
@given(data=st.data())
def test_a_log_cut_off_anywhere_is_one_clear_error(whole, data):
    folder, content, _ = whole
    length = data.draw(st.integers(0, len(content) - 1))
    (folder / "cut.nc").write_bytes(content[:length])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        report = validate_log(folder / "cut.nc")
    assert not report.ok


@settings(max_examples=250)
@given(data=st.data())
def test_flipped_bits_are_never_read_as_another_log(whole, data):
    folder, content, log = whole
    damaged = bytearray(content)
    for _ in range(data.draw(st.integers(1, 3))):
        bit = data.draw(st.integers(0, 8 * len(content) - 1))
        damaged[bit // 8] ^= 1 << bit % 8
    (folder / "flipped.nc").write_bytes(damaged)
    try:
        found = read_log(folder / "flipped.nc")
    except LogError:
        return
    # the bits lay where nothing is stored
    assert plain(found).identical(log)


@settings(max_examples=25)
@given(study=studies(), max_samples=st.integers(1, 9))
def test_blocks_put_together_again_are_the_log(study, max_samples):
    trials, options = study
    log = log_of_trials(trials, **options)
    blocks = list(iter_blocks(log, max_samples=max_samples))
    for dim in ("trial", "sample"):
        for name in [name for name in log.data_vars if log[name].dims[:1] == (dim,)]:
            joined = np.concatenate([block[name].values for block in blocks])
            np.testing.assert_array_equal(joined, log[name].values)
    found = [
        (block.segment_trial.values + block.attrs["first_trial"], block.true_goal.values) for block in blocks
    ]
    np.testing.assert_array_equal(np.concatenate([trial for trial, _ in found]), log.segment_trial.values)
    np.testing.assert_array_equal(np.concatenate([goal for _, goal in found]), log.true_goal.values)
    for block in blocks:
        assert block.sizes["sample"] <= max_samples or block.sizes["trial"] == 1
        assert validate_log(block).ok


def test_blocks_hold_only_the_variables_asked_for(tmp_path):
    write_log(small_log(), tmp_path / "log.nc")
    block = next(iter_blocks(tmp_path / "log.nc", variables=["time"]))
    assert "position" not in block
    assert "participant" in block
    with pytest.raises(LogError, match="no variables"):
        next(iter_blocks(tmp_path / "log.nc", variables=["weight"]))


def test_the_hash_of_a_folder_changes_with_names_and_contents(tmp_path):
    (tmp_path / "a").mkdir()
    (tmp_path / "a" / "x").write_text("1")
    first = file_sha256(tmp_path)
    (tmp_path / "a" / "x").rename(tmp_path / "a" / "y")
    assert file_sha256(tmp_path) != first
    with pytest.raises(LogError, match="cannot be read"):
        file_sha256(tmp_path / "nothing")


@settings(max_examples=80)
@given(data=st.data())
def test_a_zarr_store_that_is_damaged_is_never_read_as_another_log(whole_store, data):
    folder, files, log = whole_store
    shutil.rmtree(folder / "damaged.zarr", ignore_errors=True)
    shutil.copytree(folder / "log.zarr", folder / "damaged.zarr")
    path = folder / "damaged.zarr" / data.draw(st.sampled_from(files))
    content = bytearray(path.read_bytes())
    if data.draw(st.booleans()):
        content[data.draw(st.integers(0, len(content) - 1))] ^= 1 << data.draw(st.integers(0, 7))
        path.write_bytes(content)
    else:
        path.write_bytes(content[: data.draw(st.integers(0, len(content) - 1))])
    try:
        found = read_log(folder / "damaged.zarr")
    except LogError:
        return
    assert plain(found).identical(log)


@pytest.fixture(scope="module")
def whole_store(tmp_path_factory):
    """A Zarr store, the names of its files, and the log in it."""
    folder = tmp_path_factory.mktemp("store")
    write_log(small_log(), folder / "log.zarr")
    files = sorted(
        item.relative_to(folder / "log.zarr").as_posix()
        for item in (folder / "log.zarr").rglob("*")
        if item.is_file()
    )
    return folder, files, plain(read_log(folder / "log.zarr"))


def test_a_file_that_claims_more_than_it_can_hold_is_refused_before_memory_is(tmp_path):
    path = tmp_path / "log.nc"
    write_log(small_log(), path)
    with h5py.File(path, "r+") as file:
        file.create_dataset("heat", shape=(10**12,), dtype="f8", chunks=(1000,))
    assert [fault.kind for fault in validate_log(path).faults] == ["unreadable"]
