"""Berntorp et al., Algorithm 2: particles for stiffness, damping and height, and a Kalman filter for each particle's roll.

records.py      what goes in and what comes out: `Noise`, `Cloud`, `ParticleSettings` (PUBLISHED, BETTER, fixed_size), `ParticleRun`
clouds.py       the particles to start from: `uniform_cloud`, `cloud_of`
filter.py       `run_particles`: one drive
refine.py       `refine`: the whole drive's posterior by importance sampling around a run's end, and its evidence
monte_carlo.py  `run_many`: many drives, on threads
layout.py, discretise.py, kalman_step.py, sensed_step.py, adaptation.py, moves.py, statistics.py, kernels.py: the compiled parts

    prior = uniform_cloud(8000, {"K": (5e4, 8e4), "D": (3e3, 1e4), "h": (0.55, 1.2)}, mass_kg=1800, roll_inertia_kgm2=500, rng=rng)
    run = run_particles(y, accel, 0.01, prior, Noise(0.0017, 0.0052, 0.1), PUBLISHED, rng)
    run.mean[-1], run.std[-1], run.quantiles[-1]        # K, D, h
"""
