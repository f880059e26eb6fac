"""Prints the verdict of each segment of a trace: wheel.py MODEL TRACE, with the wheel alone installed."""

import csv
import sys

import bearing_watch as bw

model, trace = sys.argv[1:]
with open(trace, newline="") as file:
    rows = list(csv.DictReader(file))
table = {name: [float(row[name]) for row in rows] for name in rows[0]}
for verdict in bw.Detector(bw.Model.load(model)).run(table).verdict:
    print(verdict)
