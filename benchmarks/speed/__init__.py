"""How fast is it? Our estimators and well-known ones at the same task, side by side.

Each figure is a ratio of CPU times, other ÷ ours: above 1 we are faster. Wall clocks say little
on a shared machine; so both sides take turns in one run, each on one thread, and the middle
of five times counts. Where one time exceeds twenty seconds, it stands alone.

    python -m benchmarks.speed
    python -m benchmarks.speed --only gn/intel
"""

import os

# It is read when numpy is first imported, which this package has not done yet.
os.environ["OPENBLAS_NUM_THREADS"] = "1"
