"""The leadscrew with half the micro-step, to see what it changes."""

from dataclasses import replace

from plants.leadscrew import axis as leadscrew

model = replace(leadscrew.model, name="LeadscrewHalfStep", h_max=5e-6)
