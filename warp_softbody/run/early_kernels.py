"""What a simulation has compiled, where it has to be, before anything of it is built."""

from __future__ import annotations

from warp_softbody.controllers.compiled.search_kernels import search_kernels
from warp_softbody.device.kernel_loading import prepare
from warp_softbody.device.warp_runtime import check_device
from warp_softbody.engine.first_kernels import first_kernels, muscle_kernels, reduced_kernels
from warp_softbody.engine.options import SimulationOptions


def prepare_kernels(options: SimulationOptions, *, controlled: bool) -> None:
    """Begin to compile what every step launches, those that take longest first.

    Raises:
        InputError: there is no such device.
    """
    check_device(options.device)
    # native code for processors is of modules that other devices launch from too
    if options.device != "cpu" or not options.native_code:
        return
    precision = options.precision
    kernels = first_kernels(precision)
    if controlled:
        muscles = muscle_kernels(precision) if options.muscles == "implicit" else []
        # what is waited for while all is built comes before the rest
        kernels = [*search_kernels(), *muscles, *reduced_kernels(precision), *kernels]
    prepare(options.device, kernels)
