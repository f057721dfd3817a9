"""Chapters 6-8 of the gPC dissertation: LTM, MLTM and HFLTM beside ours."""
