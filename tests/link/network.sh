#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# network.sh: robots on one network, each in a network namespace of its own. Needs root.
#   network.sh up PREFIX N [RATE]    namespaces PREFIX1 ... PREFIXN with the addresses 10.77.0.1 ...; each
#                                    robot sends and receives at most RATE (default 256kbit)
#   network.sh loss PREFIX I PERCENT robot I loses this share of the packets that it should receive
#   network.sh cut PREFIX I          nothing reaches or leaves robot I
#   network.sh heal PREFIX I         ends loss and cut
#   network.sh run PREFIX I COMMAND  runs a command as robot I, in a session of its own; it comes before the other
#                                    programs here: a robot has a computer for itself
#   network.sh down PREFIX           removes the namespaces and ends the programs in them
set -euo pipefail

command=$1 prefix=$2
hub=${prefix}hub

thin() { # NAMESPACE DEVICE RATE: a queue of 400 ms
  ip netns exec "$1" tc qdisc add dev "$2" root tbf rate "$3" burst 6kb latency 400ms
}
filter() { # I RULE...: replaces the rules of robot I
  local robot=$prefix$1
  shift
  ip netns exec "$robot" nft -f - <<EOF
table inet link
delete table inet link
table inet link {
  chain in { type filter hook input priority 0; iifname "eth0" $1; }
  chain out { type filter hook output priority 0; oifname "eth0" ${2:-accept}; }
}
EOF
}

case $command in
  up)
    rate=${4:-256kbit}
    ip netns add "$hub"
    ip netns exec "$hub" sysctl -qw net.ipv6.conf.all.disable_ipv6=1
    ip -n "$hub" link add hub type bridge
    ip -n "$hub" link set hub up
    for i in $(seq "$3"); do
      robot=$prefix$i
      ip netns add "$robot"
      ip -n "$hub" link add "port$i" type veth peer name eth0 netns "$robot"
      ip -n "$hub" link set "port$i" master hub up
      ip -n "$robot" addr add "10.77.0.$i/24" dev eth0
      ip netns exec "$robot" sysctl -qw net.ipv6.conf.all.disable_ipv6=1
      ip -n "$robot" link set lo up
      ip -n "$robot" link set eth0 multicast on up
      ip -n "$robot" route add 224.0.0.0/4 dev eth0
      thin "$robot" eth0 "$rate"
      thin "$hub" "port$i" "$rate"
      filter "$i" accept
    done
    ;;
  loss) filter "$3" "numgen random mod 100 < $4 drop" ;;
  cut) filter "$3" drop drop ;;
  heal) filter "$3" accept ;;
  run)
    robot=$prefix$3
    shift 3
    # The kernel shares the time among sessions first, then within a session.
    exec setsid nice -n -10 ip netns exec "$robot" \
      sh -c '{ echo -10 >/proc/self/autogroup; } 2>/dev/null; exec "$@"' robot "$@"
    ;;
  down)
    for name in $(ip netns list | awk -v p="$prefix" 'index($1, p) == 1 { print $1 }'); do
      ip netns pids "$name" | xargs -r kill -9
      ip netns del "$name"
    done
    ;;
esac
