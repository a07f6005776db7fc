"""Live frames: images of a scene from poses that are known only when they are needed, many a second."""

from hcss_payload.live.client import LiveClient, ServedFrame
from hcss_payload.live.prepared_pass import PreparedPass
from hcss_payload.live.scenario_pass import live_pass
from hcss_payload.live.target import PointTarget
from hcss_payload.live.twin import LiveTwin

__all__ = ["LiveClient", "LiveTwin", "PointTarget", "PreparedPass", "ServedFrame", "live_pass"]
