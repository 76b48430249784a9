"""Reference values by OpenCV, for tests/all/opencv.rs.

    python3 crates/camera/tests/opencv.py > crates/camera/tests/opencv.json

Made with Python 3.11.7, NumPy 2.4.6, SciPy 1.17.1, OpenCV 5.0.0 (opencv-python).

`lenses`: a camera for each number of coefficients. `yaml` is the camera as cv2.FileStorage wrote
it, and `ideal` are ideal pixels. `seen` is where cv2.projectPoints (or cv2.fisheye.distortPoints)
maps them. `back` is the result of cv2.undistortPoints (or its fisheye counterpart), iterated to
1e-15, for `seen`.

`homographies`: noisy pairs of points, the result of cv2.findHomography with method 0, and that of
cv2.perspectiveTransform for further points (`lies`). With more than four pairs, OpenCV stops about
10⁻⁶ mm short of the least squares, so SciPy's least_squares continues from there (`least`).

`poses`: points of a plane, and where cv2.projectPoints maps them without distortion.
"""

import json
import os
import tempfile

import cv2
import numpy as np
from scipy.optimize import least_squares

rng = np.random.default_rng(2312)
CRITERIA = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 1000, 1e-15)


def file_storage(size, matrix, coefficients, fisheye):
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "camera.yaml")
        storage = cv2.FileStorage(path, cv2.FILE_STORAGE_WRITE)
        storage.write("image_width", size[0])
        storage.write("image_height", size[1])
        storage.write("camera_matrix", matrix)
        storage.write("distortion_coefficients", coefficients)
        if fisheye:
            storage.write("fisheye_model", 1)
        storage.release()
        with open(path, encoding="utf-8") as file:
            return file.read()


def lens(name, size, focal, center, coefficients, fisheye=False, reach=1.0):
    matrix = np.array([[focal[0], 0, center[0]], [0, focal[1], center[1]], [0, 0, 1.0]])
    coefficients = np.array(coefficients, dtype=float).reshape(-1, 1)
    share = np.stack(np.meshgrid(np.linspace(-1, 1, 9), np.linspace(-1, 1, 7)), -1).reshape(-1, 2)
    ideal = np.array(center) + reach * 0.5 * share * np.array(size) + rng.normal(0, 2, share.shape)
    rays = ((ideal - center) / focal).reshape(-1, 1, 2)
    if fisheye:
        seen = cv2.fisheye.distortPoints(rays, matrix, coefficients)
        back = cv2.fisheye.undistortPoints(seen, matrix, coefficients, P=matrix, criteria=CRITERIA)
    else:
        space = np.concatenate([rays, np.ones((len(rays), 1, 1))], axis=2)
        seen, _ = cv2.projectPoints(space, np.zeros(3), np.zeros(3), matrix, coefficients)
        back = cv2.undistortPoints(seen, matrix, coefficients, P=matrix, criteria=CRITERIA)
    return {
        "name": name,
        "yaml": file_storage(size, matrix, coefficients, fisheye),
        "ideal": ideal.tolist(),
        "seen": seen.reshape(-1, 2).tolist(),
        "back": back.reshape(-1, 2).tolist(),
    }


def homography(count, noise_mm):
    true = np.array([[0.9, 0.12, -210.0], [-0.07, 1.3, -305.0], [1.2e-4, 9.0e-4, 1.0]])
    corners = np.array([[31, 42], [610, 25], [588, 455], [60, 470]], dtype=float)
    inner = rng.uniform([20, 20], [620, 460], (max(count - 4, 0), 2))
    pixels = np.concatenate([corners, inner])[:count]
    plane = cv2.perspectiveTransform(pixels.reshape(-1, 1, 2), true).reshape(-1, 2)
    plane = plane + rng.normal(0, noise_mm, plane.shape)
    # OpenCV converts the pairs to float32, in which these numbers are exact too.
    pixels, plane = (np.round(64 * numbers) / 64 for numbers in (pixels, plane))
    found, _ = cv2.findHomography(pixels, plane, 0)
    asked = rng.uniform([0, 0], [640, 480], (20, 2))

    def lies(numbers, points):
        # Pixels divided by 300, so that all numbers have similar sizes for the solver's
        # differences.
        mapped = np.c_[points / 300, np.ones(len(points))] @ np.append(numbers, 1).reshape(3, 3).T
        return mapped[:, :2] / mapped[:, 2:]

    start = (found / found[2, 2] @ np.diag([300, 300, 1])).ravel()[:8]
    least = least_squares(lambda numbers: (lies(numbers, pixels) - plane).ravel(), start, jac="3-point",
                          x_scale="jac", xtol=1e-15, ftol=1e-15, gtol=1e-15).x
    return {
        "least": lies(least, asked).tolist(),
        "pixels": pixels.tolist(),
        "plane": plane.tolist(),
        "asked": asked.tolist(),
        "lies": cv2.perspectiveTransform(asked.reshape(-1, 1, 2), found).reshape(-1, 2).tolist(),
    }


def pose(rotation, translation):
    matrix = np.array([[610.0, 0, 322.5], [0, 605.0, 238.0], [0, 0, 1.0]])
    plane = rng.uniform([-200, -150], [200, 150], (20, 2))
    space = np.concatenate([plane, np.zeros((20, 1))], axis=1)
    rotation, translation = np.array(rotation), np.array(translation)
    seen, _ = cv2.projectPoints(space, rotation, translation, matrix, None)
    return {
        "rotation": rotation.tolist(),
        "matrix": cv2.Rodrigues(rotation)[0].tolist(),
        "translation": translation.tolist(),
        "plane": plane.tolist(),
        "seen": seen.reshape(-1, 2).tolist(),
    }


VGA, HD = (640, 480), (1920, 1080)
lenses = [
    lens("4", VGA, (612.3, 611.1), (318.2, 243.9), [-0.31, 0.12, 1.1e-3, -8e-4]),
    lens("5", VGA, (523.7, 524.9), (325.1, 236.4), [0.16, -0.29, 2.1e-3, -1.7e-3, 0.11]),
    lens("5, strong barrel", HD, (1050.0, 1052.0), (951.0, 548.0), [-0.33, 0.11, -4e-4, 3e-4, -0.014]),
    lens("8", HD, (970.2, 969.4), (963.7, 533.8), [0.48, -0.62, 4e-4, -2e-4, 0.21, 0.81, -0.51, 0.12]),
    lens("12", VGA, (580.0, 581.0), (320.5, 239.5),
         [-0.21, 0.07, 6e-4, -5e-4, -0.01, 0.02, 0.01, -0.004, 2e-3, -7e-4, -1.2e-3, 4e-4]),
    lens("14", VGA, (700.0, 701.0), (317.0, 244.0),
         [-0.18, 0.09, 3e-4, 9e-4, -0.02, 0.03, 0.01, -0.002, 1e-3, -2e-4, -8e-4, 3e-4, 0.021, -0.034]),
    lens("fisheye", VGA, (285.0, 286.2), (321.4, 242.3), [-0.012, 0.021, -0.017, 0.004], fisheye=True, reach=1.5),
    lens("fisheye, strong", HD, (560.0, 559.0), (958.0, 541.0), [0.08, -0.03, 0.012, -0.002], fisheye=True, reach=2.0),
]
result = {
    "lenses": lenses,
    "homographies": [homography(4, 0.0), homography(4, 1.0), homography(5, 0.5), homography(12, 0.5), homography(60, 2.0)],
    "poses": [
        pose([0.0, 0.0, 0.0], [10.0, -20.0, 500.0]),
        pose([0.9, -0.3, 0.2], [-15.0, 40.0, 650.0]),
        pose([2.9, 0.4, -0.1], [30.0, 10.0, 800.0]),
        pose([0.02, 1.1, 2.4], [0.0, 0.0, 900.0]),
    ],
}
print("{" + ",\n".join(f'"{key}": [' + ",\n".join(map(json.dumps, value)) + "]" for key, value in result.items()) + "}")
