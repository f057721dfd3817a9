"""Pence, Fathy & Stein beside ours."""
