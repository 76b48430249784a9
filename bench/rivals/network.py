"""The mask network by ONNX Runtime on one thread: the same weights as QLinearConv and as floats.

`lariat-bench network --python PYTHON` runs this script. The request names a file of weights, a raw
RGB picture, and the two raw maps that lariat computes from it. The head of
crates/network/src/lib.rs documents the layout of the weights. Both sides of the picture are
multiples of 16. With `keep`, the models are written next to the given name.

All integers up to the logits are equal. The maps differ where a logit is 0: 127.5 becomes 128 in
lariat and 127 here. The picture's bytes are halved and split into planes before the clock starts.
"""

import json
import statistics
import struct
import sys
import time

import timing

# For each layer: name, input, addend, and padding before and after.
LAYERS = [
    ("stem", "input", None, (0, 1)),
    ("d1", "stem", None, (0, 1)),
    ("d2", "d1", None, (0, 1)),
    ("e2a", "d2", None, None),
    ("e2b", "e2a", "d2", None),
    ("d3", "e2b", None, (0, 1)),
    ("e3a", "d3", None, None),
    ("e3b", "e3a", "d3", None),
    ("e3c", "e3b", None, None),
    ("e3d", "e3c", "e3b", None),
    ("u2", "e3d", None, None),
    ("f2", "u2", None, None),
    ("u1", "f2", None, None),
    ("f1", "u1", None, None),
    ("out", "f1", None, None),
]
# Addend of a layer after its 2× upsampling.
UPSAMPLED = {"u2": "e2b", "u1": "d1"}
GREY, ZERO, LOGIT_STEPS = 64, 128, 16


def read(path):
    """Returns each layer's stride, dilation, weights (row, column, in, out), biases and scales."""
    import numpy

    with open(path, "rb") as file:
        data = file.read()
    assert data[:8] == b"LARIATN1" and struct.unpack_from("<II", data, 8) == (1, len(LAYERS))
    at, layers = 16, []
    for _ in LAYERS:
        ins, outs, side, stride, dilation, _ = struct.unpack_from("<HHBBBB", data, at)
        at += 8
        shape = (side, side, ins, outs)
        weights = numpy.frombuffer(data, "<i1", side * side * ins * outs, at).reshape(shape)
        at += weights.size
        bias = numpy.frombuffer(data, "<i4", outs, at)
        scale = numpy.frombuffer(data, "<f4", outs, at + 4 * outs)
        at += 8 * outs
        layers.append((stride, dilation, weights, bias, scale))
    return layers


class Graph:
    """Nodes and constants of a model under construction."""

    def __init__(self):
        self.nodes, self.constants = [], []

    def constant(self, name, value):
        from onnx import numpy_helper

        if all(known.name != name for known in self.constants):
            self.constants.append(numpy_helper.from_array(value, name))
        return name

    def add(self, operator, inputs, output, **attributes):
        from onnx import helper

        self.nodes.append(helper.make_node(operator, inputs, [output], **attributes))
        return output

    def doubled(self, name):
        import numpy

        sizes = self.constant("twice", numpy.array([1, 1, 2, 2], numpy.float32))
        how = {"mode": "nearest", "nearest_mode": "floor"}
        how["coordinate_transformation_mode"] = "asymmetric"
        return self.add("Resize", [name, "", sizes], name + "_twice", **how)

    def maps(self, name, width, height):
        """Rearranges channels 16·map + 4·row + column at quarter resolution into two maps."""
        import numpy

        apart = self.constant("apart", numpy.array([1, 2, 4, 4, height // 4, width // 4]))
        whole = self.constant("whole", numpy.array([1, 2, height, width]))
        name = self.add("Reshape", [name, apart], "six")
        name = self.add("Transpose", [name], "in_order", perm=[0, 1, 4, 2, 5, 3])
        return self.add("Reshape", [name, whole], "maps")

    def model(self, width, height, kind):
        from onnx import helper

        ends = [("input", [1, 3, height, width]), ("maps", [1, 2, height, width])]
        first, last = [helper.make_tensor_value_info(name, kind, shape) for name, shape in ends]
        graph = helper.make_graph(self.nodes, "lariat", [first], [last], self.constants)
        sets = [helper.make_opsetid("", 17), helper.make_opsetid("com.microsoft", 1)]
        return helper.make_model(graph, opset_imports=sets, ir_version=8)


def window(stride, dilation, weights, pads):
    before, behind = pads or (dilation * (weights.shape[0] // 2),) * 2
    return {
        "kernel_shape": list(weights.shape[:2]),
        "strides": [stride] * 2,
        "dilations": [dilation] * 2,
        "pads": [before, before, behind, behind],
    }


def whole_numbers(layers, width, height):
    """Builds the model with QLinearConv. Every scale is 1, so the numbers equal lariat's."""
    import numpy
    from onnx import TensorProto

    graph = Graph()
    one = graph.constant("one", numpy.float32(1))
    zero, middle = [graph.constant(f"zero_{z}", numpy.uint8(z)) for z in (0, ZERO)]
    most = graph.constant("most", numpy.uint8(127))
    signed_zero = graph.constant("signed_zero", numpy.int8(0))
    for (name, source, residual, pads), layer in zip(LAYERS, layers):
        stride, dilation, weights, bias, scale = layer
        source_zero = zero
        if name == "stem":
            # The padding around the picture is its zero point.
            source_zero = graph.constant("grey", numpy.uint8(GREY))
            bias = bias + GREY * weights.astype(numpy.int32).sum((0, 1, 2))
        added = residual or UPSAMPLED.get(name)
        signed = added or name == "out"
        inputs = [source, one, source_zero]
        inputs.append(graph.constant(name + "_w", weights.transpose(3, 2, 0, 1).copy()))
        inputs += [graph.constant(name + "_scale", scale), signed_zero, one]
        inputs += [middle if signed else zero, graph.constant(name + "_b", bias.astype("i4"))]
        last = graph.add(
            "QLinearConv", inputs, name + "_sum", **window(stride, dilation, weights, pads)
        )
        if name in UPSAMPLED:
            last = graph.doubled(last)
        if added:
            inputs = [last, one, middle, added, one, zero, one, zero]
            last = graph.add("QLinearAdd", inputs, name + "_both", domain="com.microsoft")
        if name == "out":
            step = graph.constant("step", numpy.float32(1 / LOGIT_STEPS))
            share = graph.constant("share", numpy.float32(1 / 255))
            inputs = [last, step, middle, share, zero]
            last = graph.add("QLinearSigmoid", inputs, "out", domain="com.microsoft")
        else:
            graph.add("Clip", [last, "", most], name)
    graph.maps("out", width, height)
    return graph.model(width, height, TensorProto.UINT8)


def floats(layers, width, height):
    """Builds the unquantized network, in the units of its activations."""
    import numpy
    from onnx import TensorProto

    graph = Graph()
    none, most = [graph.constant(f"bound_{b}", numpy.float32(b)) for b in (0, 127)]
    for (name, source, residual, pads), layer in zip(LAYERS, layers):
        stride, dilation, weights, bias, scale = layer
        if name == "stem":
            # The zero point is already subtracted from the picture.
            bias = bias + GREY * weights.astype(numpy.int32).sum((0, 1, 2))
        real = (weights * scale).transpose(3, 2, 0, 1).astype(numpy.float32)
        inputs = [source, graph.constant(name + "_w", real.copy())]
        inputs.append(graph.constant(name + "_b", (bias * scale).astype(numpy.float32)))
        last = graph.add("Conv", inputs, name + "_sum", **window(stride, dilation, weights, pads))
        if name in UPSAMPLED:
            last = graph.doubled(last)
        added = residual or UPSAMPLED.get(name)
        if added:
            last = graph.add("Add", [last, added], name + "_both")
        if name == "out":
            steps = graph.constant("steps", numpy.float32(1 / LOGIT_STEPS))
            graph.add("Sigmoid", [graph.add("Mul", [last, steps], "logit")], "out")
        else:
            graph.add("Clip", [last, none, most], name)
    graph.maps("out", width, height)
    return graph.model(width, height, TensorProto.FLOAT)


def measured(session, picture, rounds):
    """Returns the maps and the median time of a run in nanoseconds."""
    run = lambda: session.run(None, {"input": picture})[0]  # noqa: E731
    for _ in range(3):
        maps = run()
    times = []
    for _ in range(rounds):
        start = time.perf_counter_ns()
        run()
        times.append(time.perf_counter_ns() - start)
    return maps[0], statistics.median(times)


def main(request):
    numpy, _, runtime = timing.need("numpy", "onnx", "onnxruntime")
    width, height = request["width"], request["height"]
    layers = read(request["weights"])
    rgb = numpy.fromfile(request["picture"], numpy.uint8).reshape(height, width, 3)
    ours = [numpy.fromfile(request[m], numpy.uint8).reshape(height, width) for m in ("rope", "seam")]
    ours = numpy.stack(ours).astype(numpy.float32)
    picture = (rgb >> 1).transpose(2, 0, 1)[None].copy()
    versions = {"NumPy": numpy.__version__, "ONNX Runtime": runtime.__version__}
    options = runtime.SessionOptions()
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    options.log_severity_level = 3
    kinds = [
        ("QLinearConv", whole_numbers, picture, 1),
        ("float", floats, picture.astype(numpy.float32) - GREY, 255),
    ]
    for name, make, given, factor in kinds:
        model = make(layers, width, height).SerializeToString()
        if request.get("keep"):
            with open(f"{request['keep']}-{name}.onnx", "wb") as file:
                file.write(model)
        session = runtime.InferenceSession(model, options, providers=["CPUExecutionProvider"])
        maps, median_ns = measured(session, given, request["rounds"])
        off = numpy.abs(maps.astype(numpy.float32) * factor - ours)
        line = {"name": name, "median_ns": median_ns, "versions": versions}
        line.update(mean=float(off.mean()), most=float(off.max()), other=float((off > 0.5).mean()))
        print(json.dumps(line), flush=True)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(f"usage: {sys.argv[0]} REQUEST.json (see the README beside it)")
    with open(sys.argv[1], encoding="utf-8") as file:
        main(json.load(file))
