# An entry for the benchmark that is not Python: dead reckoning, from g2o to TUM.
#
#     mkdir -p build/entry/awk
#     for world in build/entry/worlds/*.g2o; do
#         map="build/entry/awk/$(basename "$world" .g2o).tum"
#         awk -f benchmarks/entries/dead_reckoning.awk "$world" > "$map"
#     done
#
# Each edge from a pose to the next one moves on, the first of each kind; closures are not used.

function quaternion(roll) { qx = qy = 0; qz = sin(roll / 2); qw = cos(roll / 2) }

# Write the pose that the robot has reached.
function tell(id) {
    printf "%d %.17g %.17g %.17g %.17g %.17g %.17g %.17g\n", id, x, y, z, ax, ay, az, aw
}

# Move by (dx, dy, dz) and turn by (qx, qy, qz, qw), both in the frame of the robot.
function move(dx, dy, dz,    tx, ty, tz, bx, by, bz, bw) {
    tx = 2 * (ay * dz - az * dy); ty = 2 * (az * dx - ax * dz); tz = 2 * (ax * dy - ay * dx)
    x += dx + aw * tx + ay * tz - az * ty
    y += dy + aw * ty + az * tx - ax * tz
    z += dz + aw * tz + ax * ty - ay * tx
    bx = aw * qx + ax * qw + ay * qz - az * qy
    by = aw * qy - ax * qz + ay * qw + az * qx
    bz = aw * qz + ax * qy - ay * qx + az * qw
    bw = aw * qw - ax * qx - ay * qy - az * qz
    ax = bx; ay = by; az = bz; aw = bw
}

BEGIN { aw = 1; reached = 0; tell(0) }
$2 == reached && $3 == reached + 1 && $1 == "EDGE_SE2" { quaternion($6); move($4, $5, 0); tell(++reached); next }
$2 == reached && $3 == reached + 1 && $1 == "EDGE_SE3:QUAT" { qx = $7; qy = $8; qz = $9; qw = $10; move($4, $5, $6); tell(++reached) }
