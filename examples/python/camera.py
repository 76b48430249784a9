"""A camera that Python can read, as lariat's source. Run `lariat run --source external` alongside.

pip install opencv-python
python camera.py [0 | rtsp://… | video.mp4]
"""

import sys

import cv2

import lariat

name = sys.argv[1] if len(sys.argv) > 1 else "0"
camera = cv2.VideoCapture(int(name) if name.isdigit() else name)
with lariat.Writer("frames") as frames:
    while camera.grab():  # waits for the next image and takes it
        frames.write(camera.retrieve()[1], "bgr8")  # copies it once, into shared memory
