#!/usr/bin/env python3
"""One recording with two settings, their errors side by side: compare_settings.py RECORDING"""

# %% What is compared
import sys
import time

import plumbline

sequence = plumbline.open_sequence(sys.argv[1])
truth = sequence.groundtruth()

classic = plumbline.Parameters("kinectfusion")
ours = plumbline.Parameters()
for parameters in (classic, ours):
    parameters.volume.resolution = 256
    parameters.volume.side = 6
    parameters.preprocess.calibrate_depth = False  # the same depth for both

# %% The runs
runs = {}
for name, parameters in {"kinectfusion": classic, "plumbline": ours}.items():
    begin = time.perf_counter()
    runs[name] = plumbline.run(sequence, parameters=parameters, orientation="none", mesh=False)
    print(f"{name}: {time.perf_counter() - begin:.1f} s")

# %% The table
print(f"{'setting':14}{'tracked':>9}{'lost':>6}{'ATE rmse (mm)':>15}{'max (mm)':>10}")
for name, run in runs.items():
    if len(truth) and run.tracked >= 3:
        error = plumbline.evaluate(truth, run.trajectory).ate
        figures = f"{1e3 * error.rmse:15.1f}{1e3 * error.max:10.1f}"
    else:
        figures = f"{'no truth':>15}{'':10}"
    print(f"{name:14}{run.tracked:9}{run.lost:6}{figures}")
