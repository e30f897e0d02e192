"""The instruments of a scene in numbers."""

from typing import Any

from crane_sim.hardware.instruments import Camera, Imu, Instruments, Sampling
from crane_sim.scenes.hardware_settings import Periods
from crane_sim.scenes.schema.instruments import CameraGroup, ImuGroup
from crane_sim.scenes.schema.scene_file import SceneFile


def instruments_of(file: SceneFile, period: float) -> tuple[Instruments | None, dict[str, Any]]:
    """Return (the instruments of a scene with this control period [s] or None, notes on them).

    Raises:
        SceneError: a time is too many periods.
    """
    if file.imu is None and file.camera is None:
        return None, {}
    periods = Periods(period)
    imu = _imu(file.imu, periods) if file.imu is not None else None
    camera = _camera(file.camera, periods) if file.camera is not None else None
    return Instruments(imu, camera), {"rounded": periods.rounded} if periods.rounded else {}


def _imu(group: ImuGroup, periods: Periods) -> Imu:
    acceleration = group.acceleration_noise, group.acceleration_bias
    turning = group.angular_velocity_noise, group.angular_velocity_bias
    return Imu(
        _sampling("imu", group, periods),
        group.position,
        acceleration,
        turning,
        group.orientation_noise,
    )


def _camera(group: CameraGroup, periods: Periods) -> Camera:
    return Camera(_sampling("camera", group, periods), group.noise, group.bias)


def _sampling(name: str, group: ImuGroup | CameraGroup, periods: Periods) -> Sampling:
    every = 1 if group.rate is None else periods.of(f"{name}.rate", 1.0 / group.rate, least=1)
    return Sampling(every, periods.of(f"{name}.delay", group.delay))
