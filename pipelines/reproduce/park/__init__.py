"""Park & Choi beside ours."""
