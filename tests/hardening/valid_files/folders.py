"""Folders of published studies."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from .case import Case, contents, converted, made, same_log_of_a_table


def _reaching_study(folder: Path) -> None:
    rng = np.random.default_rng(1)
    (folder / "trials").mkdir()
    for game in (1, 2):
        n = 12
        xh, xr = rng.normal(size=(2, n, 4))
        np.savez(
            folder / "trials" / f"user7_cbp_{game}.npz",
            xh=xh,
            xr=xr,
            goals=rng.normal(size=(n, 3, 4)),
            belief_nominal=np.full((n, 3), 1 / 3),
            belief_beta=np.full((n, 3, 2), 1 / 6),
            r_goal_idx=np.zeros(n, int),
            collision=np.arange(n) == 3,
            team_score=np.array(4),
            r_objective=np.array(["influence", "courtesy"] * (n // 2)),
        )
    (folder / "segments.csv").write_text(
        "user_id,robot_type,game_idx,seg,start,end,arrive,h_goal\n7,cbp,1,0,0,6,5,2\n7,cbp,2,0,1,6,6,0\n"
    )
    (folder / "trials.csv").write_text("user_id,robot_type,game_idx,T\n7,cbp,1,12\n7,cbp,2,12\n")


def _eth(folder: Path) -> None:
    lines = [
        f"{780 + 6 * step} {who} {step * 0.4 + who} 0 {who - step * 0.1} 1 0 0.5"
        for step in range(8)
        for who in (1, 2)
    ]
    (folder / "obsmat.txt").write_text("\n".join(lines) + "\n")
    (folder / "destinations.txt").write_text("5 0\n-5 0\n0 7.5\n")


def folders() -> list[Case]:
    """The reaching study's folder and an ETH scene: synthetic ones, and a part of the real ones where they are."""
    from ppinfer.studies.readers.eth import read_eth
    from ppinfer.studies.readers.reaching_study import read_reaching_study

    cases = [
        Case(
            "read_reaching_study",
            made(_reaching_study),
            converted(read_reaching_study),
            "",
            {"same": same_log_of_a_table},
        ),
        Case("read_eth", made(_eth), converted(read_eth), ""),
    ]
    root = Path(os.environ.get("PPINFER_DATA", "/nowhere"))
    if (root / "eth-pedestrians").is_dir():
        real = contents(root / "eth-pedestrians")
        real["obsmat.txt"] = b"\n".join(real["obsmat.txt"].split(b"\n")[:400]) + b"\n"
        cases.append(Case("read_eth real", real, converted(read_eth), ""))
    if (root / "reaching-study").is_dir():
        real = contents(root / "reaching-study")
        games = [name for name in real if name.endswith(".npz")][:2]
        some = {name: real[name] for name in games} | {"segments.csv": b"", "trials.csv": b""}
        stems = [Path(name).stem.removeprefix("user").split("_") for name in games]
        wanted = {(stem[0], "_".join(stem[1:-1]), stem[-1]) for stem in stems}
        for name in ("segments.csv", "trials.csv"):
            head, *rows = real[name].decode().splitlines()
            columns = head.split(",")
            where = [columns.index(column) for column in ("user_id", "robot_type", "game_idx")]
            kept = [row for row in rows if tuple(row.split(",")[index] for index in where) in wanted]
            some[name] = "\n".join([head, *kept, ""]).encode()
        cases.append(
            Case(
                "read_reaching_study real",
                some,
                converted(read_reaching_study),
                "",
                {"same": same_log_of_a_table},
            )
        )
    return cases
