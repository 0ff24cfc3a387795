"""Every model of the repository that has an input can be linearised."""

from importlib import import_module

import numpy as np
import pytest
from modules import MODULES

from controllers.synthesis.linearise import linearise, without_bystanders
from fmus.model import size


@pytest.mark.parametrize("module", MODULES)
def test_a_model_has_a_finite_linearisation_unless_it_is_a_source(module):
    model = import_module(module).model
    if not size(model.input):
        with pytest.raises(ValueError, match="is a source"):
            linearise(model)
        return
    system = linearise(model)
    for matrix in (system.A, system.B, system.C, system.D):
        assert np.all(np.isfinite(matrix))
    kept = without_bystanders(system)
    assert set(kept.state_labels) <= set(system.state_labels)
    assert kept.input_labels == system.input_labels
    assert kept.output_labels == system.output_labels
