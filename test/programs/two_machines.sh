#!/bin/sh
# Two "machines" of one network, to be run by `unshare -Urn`: network namespaces joined by a cable. The plant runs on the
# first, the example's controller on the second. two_machines.sh PYTHON EXAMPLES SCENE_DURATION; prints the summary.
set -eu
python=$1 examples=$2 duration=$3
unshare -n sleep 300 &
second=$!
trap 'kill $second $controller 2>/dev/null || true' EXIT
controller=
until [ "$(readlink /proc/$second/ns/net)" != "$(readlink /proc/self/ns/net)" ]; do
    kill -0 $second || exit 1
    sleep 0.05
done
ip link add plant type veth peer name bench netns $second
ip link set lo up
ip addr add 192.0.2.1/24 dev plant
ip link set plant up
there() { nsenter -t $second -n "$@"; }
there ip link set lo up
there ip addr add 192.0.2.2/24 dev bench
there ip link set bench up
ip route add 224.0.0.0/4 dev plant
there ip route add 224.0.0.0/4 dev bench
nsenter -t $second -n "$examples/in_domain" 7 "$python" "$examples/my_controller.py" &
controller=$!
exec 3>&1
"$python" -c 'import sys; from crane_sim.cli import main; sys.exit(main())' run --no-controller --domain-id 7 \
    --duration "$duration" --no-record --json >&3
