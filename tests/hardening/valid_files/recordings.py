"""Recordings of studies."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from .case import Case, converted, made


def _record(path: Path) -> None:
    from ppinfer.studies import Segment, Trial
    from ppinfer.studies.recording import RecordingHeader, RecordingWriter

    rng = np.random.default_rng(2)
    header = RecordingHeader(agents=("human", "robot"), goals=("cup", "pan"), has_velocity=(True, False))
    with RecordingWriter(path, header) as recording:
        for index in range(4):
            velocity = rng.normal(size=(5, 2, 2))
            velocity[:, 1] = np.nan
            recording.append(
                Trial(
                    f"t{index}",
                    "p1",
                    time=np.arange(5) * 0.1,
                    position=rng.normal(size=(5, 2, 2)),
                    velocity=velocity,
                    goal_position=rng.normal(size=(2, 2)),
                    controller={"human": "person"},
                    segments=(Segment("human", 0, 4, "cup"),),
                    variables={"score": ((), np.float64(index), {"units": "1"})},
                )
            )


def recordings() -> list[Case]:
    """A recording, read as a log and as trials; and one that is resumed."""
    from ppinfer.studies.recording import load_recording, read_recording
    from ppinfer.studies.recording_lines import trial_line

    def lines(path: Path) -> Any:
        recording = load_recording(path)
        return recording.header, {trial_line(trial, recording.header) for trial in recording.trials}

    def kept(found: Any, original: Any) -> bool:
        # trials may be lost, visibly or with whole lines, but none is another than was recorded
        return bool(found[0] == original[0] and found[1] <= original[1])

    files = made(lambda folder: _record(folder / "study.jsonl"))
    return [
        Case("load_recording", files, lines, None, {"signed": True, "same": kept}),
        Case("read_recording", files, converted(read_recording)),
    ]
