"""Sprung mass by base excitation: Pence, Fathy & Stein as published, and its companion."""
