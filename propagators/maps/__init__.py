"""Light propagation maps."""

from propagators.maps.propagator import LightPropagationMaps

__all__ = ["LightPropagationMaps"]
