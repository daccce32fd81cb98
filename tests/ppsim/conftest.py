"""Small studies that the tests of the simulation share."""

import pytest

from ppinfer.studies import log_of_trials


@pytest.fixture
def log_of():
    """Return the log of the first trials of a study, without files."""

    def build(study, trials):
        header = study.header()
        log = log_of_trials(
            [study.trial(index) for index in range(trials)], agents=header.agents, goals=header.goals
        )
        log["control"].attrs["quantity"] = study.control_quantity
        return log

    return build
