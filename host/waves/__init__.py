"""Line levels of buses, rebuilt from captures."""
