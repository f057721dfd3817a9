"""Strut forces by load transfer: the published LTM, MLTM and HFLTM, and the batch companion."""
