
name = "Rolling under fins"
inputs = ("fin",)
outputs = ("roll",)
units = ("deg",)
parameters = {'w': 0.6, 'z': 0.2, 'k': 1.0, 'q': 0.001, 's': 0.1, 'roll_0': 0.0, 'rate_0': 0.0}


def matrices(theta):
    w, z, k, q, s, roll_0, rate_0 = theta
    A = [[0, 1], [-(w**2), -2 * z * w]]
    return A, [[0], [k * w**2]], [[1, 0]], None, [[0, 0], [0, q]], [[s]], [roll_0, rate_0], None
