"""The gPC-EKF for state-space systems (dissertation, Chapter 3.4-3.5), beside ours."""
