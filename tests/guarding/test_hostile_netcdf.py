"""NetCDF files that were made to do harm, or that a flipped bit made dangerous: each is refused by name."""

from __future__ import annotations

import shutil

import h5py
import numpy as np
import pytest

from ppinfer.errors import LogError
from ppinfer.guarding import limited
from ppinfer.studies import open_log, open_posterior, read_theta_posterior, validate_file, write_log
from ppinfer.testing import example_log


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    path = tmp_path_factory.mktemp("logs") / "log.nc"
    write_log(example_log(participants=1, trials=1), path)
    return path


@pytest.fixture
def copied(written, tmp_path):
    """A sound log that another process could have written."""
    return shutil.copy(written, tmp_path / "log.nc")


def linked(file):
    del file["time"]
    file["time"] = h5py.ExternalLink("/etc/passwd", "/time")


def linked_within(file):
    file["when"] = h5py.SoftLink("/time")


def grouped(file):
    file.create_group("more").create_group("and_more")


def virtual(file):
    layout = h5py.VirtualLayout(shape=(4,), dtype="f8")
    layout[:] = h5py.VirtualSource("/etc/other.h5", "time", shape=(4,))
    file.create_virtual_dataset("extra", layout)


def external(file):
    file.create_dataset("extra", (16,), "i1", external=[("/etc/passwd", 0, 16)])


def packed_otherwise(file):
    file.create_dataset("extra", data=np.zeros(100), compression="lzf", chunks=(10,))


def huge(file):
    file.create_dataset("extra", (1 << 45,), "f8", chunks=(1024,), compression="gzip")


def huge_contiguous(file):
    file.create_dataset("extra", (1 << 40,), "f8")


def records(file):
    file.create_dataset("extra", data=np.zeros(3, [("a", "i4"), ("b", "f8")]))


def references(file):
    file.create_dataset("extra", data=[file["time"].ref], dtype=h5py.ref_dtype)


def many(file):
    for index in range(5000):
        file.create_dataset(f"extra{index}", data=0.0)


def attributed(file):
    file.create_dataset("extra", data=0.0, track_order=True)
    file["extra"].attrs.create("note", np.zeros(9_000_000), dtype="f8")


HOSTILE = {
    linked: "'time' is a link to another file",
    linked_within: "'when' is a link",
    grouped: "'more' is a group",
    virtual: "'extra' is a virtual array of other files' content",
    external: "'extra' is stored in another file",
    packed_otherwise: r"'extra' is packed with the filter 'lzf' \(32000\)",
    huge: "claims 256 TiB",
    huge_contiguous: "claims 8 TiB",
    records: r"'extra' holds values of another kind \(compound\)",
    references: r"'extra' holds values of another kind \(references\)",
    many: "more than the 4096 that are read",
    attributed: "'extra' has attributes of 68.7 MiB",
}


@pytest.mark.parametrize(("change", "told"), HOSTILE.items(), ids=[change.__name__ for change in HOSTILE])
def test_what_no_log_holds_is_refused_by_name(copied, change, told):
    with h5py.File(copied, "r+", libver="latest") as file:
        change(file)
    with pytest.raises(LogError, match=told) as raised:
        open_log(copied)
    assert str(raised.value).count(str(copied)) == 1
    report = validate_file(copied)
    assert report.fault_counts == {"unreadable": 1}
    assert str(raised.value).removeprefix(f"{copied}: ") in str(report.faults[0])


@pytest.mark.parametrize("read", [open_posterior, read_theta_posterior])
def test_a_posterior_is_held_to_the_same(copied, read):
    with h5py.File(copied, "r+") as file:
        external(file)
    with pytest.raises(LogError, match="'extra' is stored in another file"):
        read(copied)


def test_texts_that_are_all_the_same_large_one_are_refused_in_bounded_memory(copied):
    with h5py.File(copied, "r+") as file:
        texts = file.create_dataset("extra", data=["x" * 1_000_000] + [""] * 3999, dtype=h5py.string_dtype())
        offset, size = texts.id.get_offset(), texts.id.get_storage_size() // 4000
    with open(copied, "r+b") as raw:
        raw.seek(offset)
        first = raw.read(size)
        raw.seek(offset)
        # all of them are now where the first one is: 4 GB of text in a file of 1 MB
        raw.write(first * 4000)
    with limited(memory=1 << 27), pytest.raises(LogError, match=r"takes more than 128 MiB of memory"):
        open_log(copied)


def test_a_log_that_unpacks_to_more_than_it_may_is_refused_and_can_be_allowed(copied):
    with limited(memory=1000), pytest.raises(LogError, match=r"claims .* more than the 1e\+03 bytes"):
        open_log(copied)
    open_log(copied).close()


def test_a_zip_archive_of_a_log_is_to_be_unpacked_first(tmp_path):
    (tmp_path / "log.zarr.zip").write_bytes(b"PK\x03\x04" + bytes(100))
    with pytest.raises(LogError, match="is a zip archive; unpack it"):
        open_log(tmp_path / "log.zarr.zip")


def test_a_log_that_came_from_elsewhere_is_read_as_it_is(copied, written):
    with open_log(copied, load=True, verify=True) as log:
        assert log.identical(open_log(written, load=True))
    assert validate_file(copied).ok


def test_a_digest_that_does_not_match_is_told_without_reading_the_log_twice(copied):
    with h5py.File(copied, "r+") as file:
        file["time"][1] += 0.01
    with pytest.raises(LogError, match="does not match its checksum"):
        open_log(copied, verify=True)
    assert "checksum" in validate_file(copied).fault_counts
    with open_log(copied) as log:
        assert log.sizes["trial"] == 1
