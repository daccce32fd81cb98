"""``python -m ppinfer``: the `ppinfer` command."""

import sys

from ppinfer.cli import main

sys.exit(main())
