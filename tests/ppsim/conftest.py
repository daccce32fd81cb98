"""Small studies that the tests of the simulation share."""

import pytest

from ppinfer.studies import log_of_trials


@pytest.fixture
def log_of():
    """Return the log of the first trials of a study, without files."""

    def build(study, trials):
        header = study.header()
        return log_of_trials(
            [study.trial(index) for index in range(trials)],
            agents=header.agents,
            goals=header.goals,
            control_quantity=header.control_quantity,
        )

    return build
