"""Settings that Open3D needs without a screen."""

import os

os.environ.setdefault("OPEN3D_DISABLE_WEB_VISUALIZER", "true")  # else it starts a server in notebooks
