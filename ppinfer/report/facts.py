"""Facts, each a name and what is told under it: how pages say numbers, counts and configurations in words."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Container, Iterable, Mapping

Facts = list[tuple[str, str]]
_MOST_NAMED = 12


def configuration_facts(text: object, *, without: Container[str] = ()) -> Facts:
    """Say what a configuration in JSON says, one line a value."""
    parsed = parsed_configuration(text)
    if not parsed:
        return [("configuration", str(text))] if text else []
    return _flat({key: value for key, value in parsed.items() if key not in without})


def parsed_configuration(text: object) -> dict[str, object]:
    """Return a configuration in JSON; empty where it is something else."""
    try:
        parsed = json.loads(str(text))
    except ValueError:
        return {}
    return parsed if isinstance(parsed, dict) else {}


def _flat(tree: Mapping[str, object], prefix: str = "") -> Facts:
    facts: Facts = []
    for key, value in tree.items():
        if isinstance(value, dict):
            facts += _flat(value, f"{prefix}{key}: ")
        else:
            # ten digits: 0.1 that was measured as 0.10000000000000053 reads as 0.1
            shown = f"{value:.10g}" if isinstance(value, float) else json.dumps(value)
            facts.append((f"{prefix}{key}", value if isinstance(value, str) else shown))
    return facts


def shown_time(seconds: float) -> str:
    """Return a duration in the unit that suits it.

    Examples
    --------
    >>> shown_time(0.5), shown_time(600.0), shown_time(9000.0)
    ('0.5 s', '10.0 min', '2.5 h')
    """
    if seconds < 120:
        return f"{seconds:.3g} s"
    return f"{seconds / 60:.1f} min" if seconds < 7200 else f"{seconds / 3600:.1f} h"


def counted(names: Iterable[str]) -> str:
    """Say which names there are and how often each.

    Examples
    --------
    >>> counted(["a", "b", "a", ""])
    'a: 2, b: 1, unknown: 1'
    """
    counts = Counter(names)
    shown = [f"{name or 'unknown'}: {count:,}" for name, count in list(counts.items())[:_MOST_NAMED]]
    between = "; " if any(", " in name for name in counts) else ", "
    return between.join(shown) + f"{between}..." * (len(counts) > _MOST_NAMED)


def listed(names: Iterable[str]) -> str:
    """Name the first of some names, and say how many there are.

    Examples
    --------
    >>> listed(["cup", "pan"])
    '2: cup, pan'
    """
    names = list(names)
    return f"{len(names):,}: {', '.join(names[:_MOST_NAMED])}{', ...' * (len(names) > _MOST_NAMED)}"
