"""What Python in the browser does first, in the pages and in the lab alike."""

import time

# The CPU's clock stands still there, so that limits of CPU time would never pass.
time.process_time = time.perf_counter
