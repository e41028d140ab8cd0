"""Plots of a study.

`plots` has a function plot_NAME(study, axes=None) for each plot, which Python programs can call too: it draws into these
axes, or into a new figure, and returns the axes, or None if the study has nothing to draw. `study` is a directory or
what read_study() returns. `program` draws all of them into files. Nothing is imported here, because the program
changes its folder first.
"""
