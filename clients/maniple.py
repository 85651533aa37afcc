#!/usr/bin/env python3
"""A client of Maniple in one file, with nothing but the standard library.

As a program it plays one seat: it sends its units straight to their zone, and who is stopped steps aside.

    python3 maniple.py HOST PORT [TOKEN] [--binary] [--conformance]

As a module it is the start of a bot of your own:

    from maniple import Bot, play

    class Mine(Bot):
        def on_cycle(self, view):
            for unit in view.mine():
                self.move(unit.handle, 10.0, 20.0)

    print(play(Mine(), "127.0.0.1", 7171, "TOKEN"))

What is on the wire is told in docs/PROTOCOL.md; numbers of sections in this file are those of that document.
"""

import argparse
import json
import math
import random
import socket
import struct
import sys
import time

PROTOCOL = 3
MESSAGE_MAX = 16384  # bytes of a message to the server
RECONNECTS_MAX = 3  # times that a connection which breaks without a reason is opened again

MODES = ("normal", "switching", "alternate", "switching_back", "site")
ACTIONS = ("none", "gather", "build")
TASKS = ("none", "attack", "attack_at", "attack_move", "hold", "gather", "return_load", "build")


class Trouble(Exception):
    """Why a client cannot go on."""


class Cut(Exception):
    """The connection broke without a word of the server."""


class Bot:
    """What decides. Take a subclass, override the three `on_` functions, and call the orders from within them."""

    name = "python"

    def __init__(self):
        self.orders = []  # what goes out after `on_cycle`

    def on_start(self, view):
        """The match begins, or goes on after the connection had broken. The view has rules and terrain, no objects."""

    def on_cycle(self, view):
        """A cycle has passed: `view` is how it is now, `view.delta` what has changed."""

    def on_end(self, result):
        """The match is over."""

    def order(self, name, **fields):
        """Gives any command of section 4. Its result comes in `view.delta["results"]` with the number returned."""
        self.orders.append({name: fields} if fields else name)
        return len(self.orders) - 1

    def move(self, handle, x, y, speed=None, queue=False):
        return self.order("move", object=handle, x=float(x), y=float(y), s=speed, queue=queue)

    def path(self, handle, *points):
        return self.order("path", object=handle, points=[[float(x), float(y), None] for x, y in points])

    def stop(self, handle):
        return self.order("stop", object=handle)

    def attack(self, handle, target):
        return self.order("attack", object=handle, target=target)

    def attack_move(self, handle, x, y):
        return self.order("attack_move", object=handle, x=float(x), y=float(y))

    def gather(self, handle, patch):
        return self.order("gather", object=handle, patch=patch)

    def build(self, handle, unit_type, x, y):
        return self.order("build", object=handle, unit_type=unit_type, x=float(x), y=float(y))

    def train(self, handle, unit_type):
        return self.order("train", object=handle, unit_type=unit_type)

    def resign(self):
        return self.order("resign")


class Object:
    """An object in sight, with the fields of `appeared` in section 6."""

    def __init__(self, appeared):
        self.handle = appeared["object"]
        self.unit_type = appeared["unit_type"]  # a place in `rules["unit_types"]`
        self.owner = appeared["owner"]  # a seat; None: nobody's
        self.base = appeared["base"]
        self.status = appeared["status"]
        self.own = appeared["own"]  # None: not ours

    @property
    def is_moving(self):
        return self.base["velocity"] != [0.0, 0.0]

    def hash(self):
        (x, y), (vx, vy) = self.base["point"], self.base["velocity"]
        status, own = self.status, self.own
        data = struct.pack(
            "<IHHddIdddIIBB", self.handle, self.unit_type, or_ones(self.owner, 16), x, y, self.base["cycle"],
            self.base["fraction"], vx, vy, or_ones(status["hit_points"], 32), or_ones(status["amount"], 32),
            MODES.index(status["mode"]), ACTIONS.index(status["action"]))
        if own is not None:
            data += struct.pack(
                "<IBIIHII", own["queued"], TASKS.index(own["task"]), own["load"], own["ready"],
                or_ones(own["training"], 16), own["waiting"], or_ones(own["due"], 32))
        return fnv(data)


class View:
    """What the player knows, kept up to date with the deltas of the server and compared after each."""

    def __init__(self, welcome):
        self.welcome = welcome
        self.forget()

    def forget(self):
        """Starts anew: the next delta is a keyframe."""
        welcome = self.welcome
        self.seat = welcome["seat"]
        self.rules = welcome["rules"]
        self.clock = welcome["clock"]
        self.width = welcome["terrain"]["width"]
        self.height = welcome["terrain"]["height"]
        self.tiles = [list(row) for row in welcome["terrain"]["tiles"]]  # tiles[y][x]
        self.walls = list(welcome["terrain"]["segments"])
        self.visible = bytearray(self.width * self.height) if self.rules["fog"] else None
        self.cycle = welcome["cycle"]
        self.objects = {}  # by handle
        self.stock = 0
        self.delta = None  # the last one
        self.sum = 0  # of all hashes of section 8

    def mine(self):
        """Returns the own objects, by handle."""
        return sorted((each for each in self.objects.values() if each.owner == self.seat), key=lambda each: each.handle)

    def type_of(self, thing):
        return self.rules["unit_types"][thing.unit_type]

    def position(self, thing):
        """Returns where an object is now: section 7, to the server's bits."""
        base = thing.base
        passed = (float(self.cycle) - float(base["cycle"])) - base["fraction"]
        return [p + v * passed for p, v in zip(base["point"], base["velocity"])]

    def is_visible(self, x, y):
        return self.visible is None or bool(self.visible[y * self.width + x])

    def apply(self, delta):
        """Changes the view by a delta, and compares its hash."""
        self.delta, self.cycle = delta, delta["cycle"]
        if delta["stock"] is not None:
            self.stock = delta["stock"]
        self._apply_ground(delta)
        for handle in delta["vanished"] + delta["died"]:
            self.sum -= self._known(handle).hash()
            del self.objects[handle]
        for moved in delta["moved"]:
            self._change(moved["object"], base=moved["base"])
        for stop in delta["stopped"]:
            base = {key: stop[key] for key in ("point", "cycle", "fraction")}
            self._change(stop["object"], base={**base, "velocity": [0.0, 0.0]})
        for changed in delta["changed"]:
            self._change(changed["object"], status=changed["status"], own=changed["own"])
        for appeared in delta["appeared"]:
            new = self.objects[appeared["object"]] = Object(appeared)
            self.sum += new.hash()
        if self.check() != delta["check"]:
            raise Trouble(f"after the delta of cycle {self.cycle} the view hashes to {self.check()}, "
                          f"the server's to {delta['check']}")

    def check(self):
        """Returns the hash of the view: section 8."""
        return f"{fnv(struct.pack('<IIQ', self.cycle, self.stock, self.sum % 2**64)):016x}"

    def _known(self, handle):
        if handle not in self.objects:
            raise Trouble(f"the delta of cycle {self.cycle} changes object {handle}, which is not in the view")
        return self.objects[handle]

    def _change(self, handle, **fields):
        thing = self._known(handle)
        self.sum -= thing.hash()
        for key, value in fields.items():
            if value is not None:
                setattr(thing, key, value)
        self.sum += thing.hash()

    def _apply_ground(self, delta):
        at = 0
        for skip, count in delta["sight"]:
            for tile in range(at + skip, at + skip + count):
                self.visible[tile] ^= 1
                sign = 1 if self.visible[tile] else -1
                self.sum += sign * fnv(struct.pack("<IB", tile, ord("*")))
            at += skip + count
        for x, y, tiles in delta["revealed"]:
            self.tiles[y][x:x + len(tiles)] = tiles
            for offset, tile in enumerate(tiles):
                self.sum += fnv(struct.pack("<IB", y * self.width + x + offset, ord(tile)))
        for wall in delta["walls"]:
            self.walls.append(wall)
            self.sum += fnv(struct.pack("<dddd", *wall))


def fnv(data):
    """FNV-1a with 64 bits (Fowler, Noll and Vo, 1991)."""
    h = 0xcbf29ce484222325
    for byte in data:
        h = (h ^ byte) * 0x100000001b3 & 0xffffffffffffffff
    return h


def or_ones(value, bits):
    return 2**bits - 1 if value is None else value


# --- binary: section 3. Values are the ones that JSON gives, so nothing else here minds which of the two is spoken.


class Body:
    """The bytes of a message that are left to read."""

    def __init__(self, data):
        self.data, self.at = data, 0

    def take(self, count):
        self.at += count
        if self.at > len(self.data):
            raise Trouble("the server sent a message that ends too early")
        return self.data[self.at - count:self.at]


class Kind:
    """A type: `read(body)` returns a value, `write(value)` bytes."""

    def __init__(self, read, write):
        self.read, self.write = read, write


def read_varint(body):
    first = body.take(1)[0]
    return first if first < 251 else int.from_bytes(body.take({251: 2, 252: 4, 253: 8}[first]), "little")


def write_varint(value):
    if value < 251:
        return bytes([value])
    tag, size = (251, 2) if value < 2**16 else (252, 4) if value < 2**32 else (253, 8)
    return bytes([tag]) + value.to_bytes(size, "little")


UINT = Kind(read_varint, write_varint)
DOUBLE = Kind(lambda body: struct.unpack("<d", body.take(8))[0], lambda value: struct.pack("<d", value))
FLAG = Kind(lambda body: body.take(1)[0] == 1, lambda value: b"\1" if value else b"\0")
BYTE = Kind(lambda body: body.take(1)[0], lambda value: bytes([value]))
DIGEST = Kind(lambda body: f"{read_varint(body):016x}", lambda value: write_varint(int(value, 16)))
TEXT = Kind(lambda body: body.take(read_varint(body)).decode(),
            lambda value: write_varint(len(value.encode())) + value.encode())
BYTES = Kind(lambda body: body.take(read_varint(body)), lambda value: write_varint(len(value)) + value)


def list_of(kind):
    return Kind(lambda body: [kind.read(body) for _ in range(read_varint(body))],
                lambda values: write_varint(len(values)) + b"".join(map(kind.write, values)))


def option(kind):
    return Kind(lambda body: kind.read(body) if FLAG.read(body) else None,
                lambda value: b"\0" if value is None else b"\1" + kind.write(value))


def sequence(*kinds):
    return Kind(lambda body: [kind.read(body) for kind in kinds],
                lambda values: b"".join(kind.write(value) for kind, value in zip(kinds, values)))


def record(**fields):
    return Kind(lambda body: {name: kind.read(body) for name, kind in fields.items()},
                lambda value: b"".join(kind.write(value.get(name)) for name, kind in fields.items()))


def enum(*plain, **with_fields):
    """A choice of names without fields, or in the order of the document with `name=None` for those without."""
    variants = [(name, None) for name in plain] + list(with_fields.items())
    tags = {name: tag for tag, (name, _) in enumerate(variants)}

    def read(body):
        name, kind = variants[read_varint(body)]
        return {name: kind.read(body)} if kind else name

    def write(value):
        name = value if isinstance(value, str) else next(iter(value))
        tag = tags[name]
        kind = variants[tag][1]
        return write_varint(tag) + (kind.write(value[name]) if kind else b"")

    return Kind(read, write)


UINTS = list_of(UINT)
POINT = sequence(DOUBLE, DOUBLE)
START = option(sequence(UINT, DOUBLE))
UNIT = record(object=UINT)
UNIT_TO = record(object=UINT, x=DOUBLE, y=DOUBLE)
COMMAND = enum(
    move=record(object=UINT, x=DOUBLE, y=DOUBLE, s=option(DOUBLE), queue=FLAG, start=START),
    path=record(object=UINT, points=list_of(sequence(DOUBLE, DOUBLE, option(DOUBLE))), start=START),
    stop=UNIT, resign=None, attack=record(object=UINT, target=UINT), attack_at=UNIT_TO, attack_move=UNIT_TO,
    hold=UNIT, gather=record(object=UINT, patch=UINT), return_load=UNIT,
    build=record(object=UINT, unit_type=UINT, x=DOUBLE, y=DOUBLE), train=record(object=UINT, unit_type=UINT),
    cancel=UNIT, switch=UNIT)
FROM_CLIENT = enum(
    hello=record(protocol=UINT, client=TEXT, player=TEXT, token=TEXT),
    commands=record(seen_cycle=UINT, list=list_of(record(seq=UINT, command=COMMAND))),
    done=record(cycle=UINT), ping=record(id=UINT), pause=record(on=FLAG),
    watch=record(protocol=UINT, client=TEXT, view=enum(everything=None, seat=UINT)), list=record(protocol=UINT),
    create=record(protocol=UINT, scenario=TEXT, clock=enum("realtime", "lockstep"), open=FLAG),
    enter=record(match=DIGEST, seat=option(UINT)))

LAYER = enum("ground", "air")
WEAPON = record(
    range=DOUBLE, range_min=DOUBLE, cooldown=UINT, damage_min=UINT, damage_max=UINT,
    splash=option(record(radius=DOUBLE, falloff=enum("none", "linear"))), targets=list_of(LAYER))
UNIT_TYPE = record(
    name=TEXT, shape=enum(circle=record(radius=DOUBLE), rectangle=record(width=DOUBLE, height=DOUBLE)),
    layer=LAYER, speed=DOUBLE, sight=DOUBLE, hit_points=option(UINT), armor=UINT, weapon=option(WEAPON),
    alternate=option(record(name=TEXT, switch_cycles=UINT, speed=DOUBLE, armor=UINT, weapon=option(WEAPON))),
    harvest=option(record(load_max=UINT, cycles_each=UINT)), patch_places=option(UINT), takes_loads=FLAG,
    making=record(cost=UINT, cycles=UINT, requires=UINTS), trains=UINTS, builds=UINTS)
OBJECTIVE = enum(
    race=record(zones=list_of(record(seat=UINT, min=POINT, max=POINT))), resources=record(goal=option(UINT)),
    kills=None, buildings=None, last_standing=None, survive=record(team=UINT))
RULES = record(
    scenario=TEXT, cycles_max=UINT, players=list_of(TEXT), unit_types=list_of(UNIT_TYPE),
    stops=enum("both", "approaching"), skin=DOUBLE, waypoints_max=UINT, commands_a_cycle_max=UINT,
    objective=OBJECTIVE, teams=UINTS, friendly_fire=FLAG, objects_max=UINT, training_max=UINT, fog=FLAG,
    terrain=enum("known", "explored"), walls_block=FLAG,
    identity=enum("fresh", "persistent"), positions=enum(exact=None, grid=record(bits=BYTE)))
WALL = sequence(DOUBLE, DOUBLE, DOUBLE, DOUBLE)
WELCOME = record(
    match=DIGEST, seat=option(UINT), delay=option(UINT), seats=UINT, cycle=UINT, rate=DOUBLE, clock=enum("realtime", "lockstep"), rules=RULES,
    terrain=record(width=UINT, height=UINT, tiles=list_of(TEXT), segments=list_of(WALL)))
REFUSED = enum(
    protocol=record(supported=UINT), handshake=None, timeout=record(seconds=UINT), name_too_long=record(limit=UINT),
    token=None, full=None, replaced=None, malformed=record(place=TEXT, problem=TEXT), too_large=record(limit=UINT),
    too_slow=None, shutdown=None, no_spectators=None, seats_only=None, no_such_seat=record(seats=UINT),
    spectators_full=record(limit=UINT), spectator=None, held_too_much=None, broken=None, no_match=None, no_scenario=None,
    matches_full=record(limit=UINT), address_full=record(limit=UINT), draining=None, not_begun=record(seconds=UINT),
    asks_too_much=record(limit=UINT), operator=None, too_many_commands=record(limit=UINT))
TALLY = record(
    units=UINT, arrived=UINT, arrival_sum=UINT, gathered=UINT, made=UINT, units_destroyed=UINT,
    buildings_destroyed=UINT, units_lost=UINT, buildings_lost=UINT, last_building=UINT)
RESULT = record(
    winners=UINTS, reason=enum("objective", "length", "resigned"), cycles=UINT,
    scores=list_of(record(seat=UINT, name=TEXT, team=UINT, points=UINT, tally=TALLY, resigned=FLAG)), hash=DIGEST)
REFUSAL = enum(
    unknown_handle=None, out_of_world=record(width=UINT, height=UINT), bad_number=record(field=TEXT, problem=TEXT),
    too_fast=record(max=DOUBLE), unknown_action=None, too_many_waypoints=record(max=UINT), empty_path=None,
    too_many_commands=record(max=UINT), start_in_past=record(now=UINT), out=None, unknown_target=None,
    bad_target=None, busy=None, not_affordable=record(cost=UINT, stock=UINT), missing=record(unit_type=UINT),
    training_full=record(max=UINT), too_many_objects=record(max=UINT), nothing_to_cancel=None, bad_place=None,
    nothing_to_return=None)
OUTCOME = enum(applied=record(cycle=UINT, late=UINT), refused=record(reason=REFUSAL))
BASE = record(point=POINT, cycle=UINT, fraction=DOUBLE, velocity=POINT)
TASK = enum(*TASKS)
STATUS = record(hit_points=option(UINT), amount=option(UINT), mode=enum(*MODES), action=enum(*ACTIONS))
OWN = record(
    queued=UINT, task=TASK, load=UINT, ready=UINT, training=option(UINT), waiting=UINT, due=option(UINT))
STOP_REASON = enum(arrived=None, ordered=None, object=record(other=option(UINT)), segment=None, edge=None)
ENDED = record(
    object=UINT, task=TASK,
    why=enum("done", "blocked", "lost", "empty", "no_room", "not_affordable", "missing", "too_many"))
SEEN = {"object": UINT, "unit_type": UINT, "owner": option(UINT)}
SHOWN = {"status": STATUS, "own": option(OWN)}
REST = {  # what a packed delta has as it is
    "results": list_of(record(seq=UINT, outcome=OUTCOME)), "sight": list_of(sequence(UINT, UINT)),
    "revealed": list_of(sequence(UINT, UINT, TEXT)), "walls": list_of(WALL),
    "appeared": list_of(record(**SEEN, **SHOWN)), "vanished": UINTS, "died": UINTS,
    "changed": list_of(record(object=UINT, status=option(STATUS), own=option(OWN))),
    "shots": list_of(record(object=UINT, target=option(UINT))), "ended": list_of(ENDED), "stock": option(UINT)}
BEFORE, AFTER = ("results", "sight", "revealed", "walls"), ("vanished", "died", "changed", "shots", "ended", "stock")
DELTA = {
    **{name: REST[name] for name in BEFORE}, "appeared": list_of(record(**SEEN, base=BASE, **SHOWN)),
    "moved": list_of(record(object=UINT, base=BASE)),
    "stopped": list_of(record(object=UINT, point=POINT, cycle=UINT, fraction=DOUBLE, reason=option(STOP_REASON))),
    **{name: REST[name] for name in AFTER}}
LISTED = record(
    match=DIGEST, scenario=TEXT, clock=enum("realtime", "lockstep"), rate=DOUBLE, has_begun=FLAG,
    seats=list_of(record(open=FLAG, taken=FLAG)), spectators=option(record(everything=FLAG, delay=UINT)))
FROM_SERVER = enum(
    welcome=WELCOME, refused=record(reason=REFUSED), delta=record(cycle=UINT, **DELTA, check=DIGEST),
    pong=record(id=UINT, cycle=UINT, fraction=DOUBLE), ended=record(result=RESULT),
    packed=record(cycle=UINT, rest=option(record(**REST)), motions=BYTES, check=DIGEST),
    paused=record(seats=UINTS, on=FLAG), matches=record(scenarios=list_of(TEXT), list=list_of(LISTED)),
    created=record(match=DIGEST, tokens=list_of(TEXT)), keyframe=record(), warned=record(reason=REFUSED, left=UINT))
NO_REST = {name: None if name == "stock" else [] for name in REST}


def unpacked(packed, view):
    """Returns the delta that a packed one stands for: section 6, *Packed*."""
    delta = {**(packed["rest"] or NO_REST), "cycle": packed["cycle"], "check": packed["check"]}
    motions = Motions(packed["motions"], packed["cycle"], view)
    delta["appeared"] = [{**each, "base": motions.motion(each["unit_type"], None)} for each in delta["appeared"]]
    delta["moved"], delta["stopped"] = motions.moved(), motions.stopped()
    return delta


class Motions(Body):
    """The motions of a packed delta, which leave out what the view can tell."""

    REASONS = (None, "arrived", "ordered", "segment", "edge")

    def __init__(self, data, cycle, view):
        super().__init__(data)
        self.cycle, self.view = cycle, view
        positions = view.rules["positions"]
        self.is_exact = positions == "exact"
        self.step = None if self.is_exact else 2.0 ** -positions["grid"]["bits"]  # of points
        self.pace = None if self.is_exact else self.step / 256  # of velocities

    def moved(self):
        moved, handle = [], -1
        for _ in range(self.unsigned() if self.data else 0):
            handle += 1 + self.unsigned()
            thing = self.view.objects[handle]
            moved.append({"object": handle, "base": self.motion(thing.unit_type, thing.base)})
        return moved

    def stopped(self):
        stopped, handle = [], -1
        while self.at < len(self.data):
            handle += 1 + self.unsigned()
            flags = self.take(1)[0]
            spot, why = self.spot(flags, self.view.objects[handle].base), flags >> 4
            reason = self.REASONS[why] if why < 5 else {"object": {"other": self.unsigned() if why == 6 else None}}
            stopped.append({"object": handle, **spot, "reason": reason})
        return stopped

    def motion(self, unit_type, before):
        flags = self.take(1)[0]
        spot, how = self.spot(flags, before), flags >> 4 & 3
        if how == 0:
            return {**spot, "velocity": [self.number(self.pace), self.number(self.pace)]}
        if how == 3:
            return {**spot, "velocity": [0.0, 0.0]}
        kind = self.view.rules["unit_types"][unit_type]
        speed, given = (kind if how == 1 else kind["alternate"])["speed"], self.number(self.pace)
        follows = math.sqrt(max(speed * speed - given * given, 0.0))
        other = self.differing(self.near(follows, self.pace), self.pace)
        other = -other if flags & 128 else other
        return {**spot, "velocity": [other, given] if flags & 64 else [given, other]}

    def spot(self, flags, before):
        ago = (1, 1, 0, None)[flags & 3]
        ago = self.unsigned() if ago is None else ago
        fraction = 0.0
        if flags & 1:
            fraction = self.number(None) if self.is_exact else self.unsigned() / 256
        if flags >> 2 & 3 == 2:
            point = [self.number(self.step), self.number(self.step)]
        else:
            time = float(self.cycle - ago) - float(before["cycle"]) - before["fraction"] + fraction
            point = [self.near(p + v * time, self.step) for p, v in zip(before["point"], before["velocity"])]
            if flags >> 2 & 3 == 1:
                point = [self.differing(each, self.step) for each in point]
        return {"point": point, "cycle": self.cycle - ago, "fraction": fraction}

    def number(self, step):
        return struct.unpack("<d", self.take(8))[0] if step is None else self.signed() * step

    def near(self, value, step):
        return value if step is None else math.floor(value / step + 0.5) * step

    def differing(self, value, step):
        """Returns the number that is so many steps away, or so many doubles."""
        if step is not None:
            return value + self.signed() * step
        turned = lambda bits: bits if bits >= 0 else bits ^ 2**63 - 1  # the doubles in order, and back
        place = turned(struct.unpack("<q", struct.pack("<d", value))[0]) + self.signed()
        return struct.unpack("<d", struct.pack("<q", turned((place + 2**63) % 2**64 - 2**63)))[0]

    def unsigned(self):
        value, shift, byte = 0, 0, 128
        while byte & 128:
            byte = self.take(1)[0]
            value |= (byte & 127) << shift
            shift += 7
        return value

    def signed(self):
        value = self.unsigned()
        return value >> 1 ^ -(value & 1)


# --- the connection


class Link:
    """One connection: messages in both directions."""

    def __init__(self, host, port, binary):
        self.binary = binary
        try:
            self.socket = socket.create_connection((host, port))
        except OSError as error:
            raise Trouble(f"{host}:{port}: {error}") from error
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.stream = self.socket.makefile("rb")
        self.preamble = b"MNPL" if binary else b""

    def encode(self, message):
        if self.binary:
            return FROM_CLIENT.write(message)
        return json.dumps(message, separators=(",", ":"), allow_nan=False).encode()

    def say(self, *messages):
        """Sends messages in one write. That the server has gone is told by `hear`."""
        data, self.preamble = self.preamble, b""
        for body in map(self.encode, messages):
            data += struct.pack("<I", len(body)) + body if self.binary else body + b"\n"
        try:
            self.socket.sendall(data)
        except OSError:
            pass

    def hear(self):
        """Returns name and fields of the next message."""
        try:
            if self.binary:
                (length,) = struct.unpack("<I", self._exactly(4))
                message = FROM_SERVER.read(Body(self._exactly(length)))
            else:
                line = self.stream.readline()
                if not line.endswith(b"\n"):
                    raise Cut
                message = json.loads(line)
        except OSError as error:
            raise Cut from error
        return next(iter(message.items()))

    def close(self):
        self.stream.close()
        self.socket.close()

    def commands(self, cycle, orders):
        """Returns the messages that it takes to give these numbered orders, none of them too long."""
        if not orders:
            return []
        message = {"commands": {"seen_cycle": cycle, "list": orders}}
        if len(orders) == 1 or len(self.encode(message)) <= MESSAGE_MAX:
            return [message]
        half = len(orders) // 2
        return self.commands(cycle, orders[:half]) + self.commands(cycle, orders[half:])

    def _exactly(self, count):
        data = self.stream.read(count)
        if len(data) < count:
            raise Cut
        return data


def play(bot, host, port, token="", binary=False, conformance=False, match=None):
    """Plays a match to its end; returns its result, and under `checks` how many times the two views agreed.

    With `conformance` it tells the server the low half of each check, as `maniple conformance serve` wants to see.
    """
    checks = 0
    for _ in range(1 + RECONNECTS_MAX):
        link = Link(host, port, binary)
        if match:
            link.say({"enter": {"match": match, "seat": None}})
        link.say({"hello": {"protocol": PROTOCOL, "client": "maniple.py 1.0", "player": bot.name, "token": token}})
        view = None
        try:
            while True:
                name, fields = link.hear()
                if name == "welcome":
                    view = View(fields)
                    bot.on_start(view)
                elif name in ("delta", "packed"):
                    view.apply(fields if name == "delta" else unpacked(fields, view))
                    checks += 1
                    link.say(*answer(link, view, bot, conformance))
                elif name == "refused":
                    raise Trouble(f"the server refused: {json.dumps(fields['reason'])}")
                elif name == "ended":
                    bot.on_end(fields["result"])
                    return {**fields["result"], "seat": view.seat, "checks": checks}
                elif name == "keyframe":
                    view.forget()
                elif name == "warned":
                    print(f"the server warns: {json.dumps(fields['reason'])}", file=sys.stderr)
                # `pong` and `paused` need no answer.
        except Cut:
            if view is None or not token:
                break
            time.sleep(0.2)  # the server lets nobody in more often
        finally:
            link.close()
    raise Trouble("the server closed the connection without a word")


def answer(link, view, bot, conformance):
    """Returns what is to be said about the present view."""
    bot.orders = []
    bot.on_cycle(view)
    orders = [{"seq": seq, "command": command} for seq, command in enumerate(bot.orders)]
    messages = link.commands(view.cycle, orders)
    if conformance:
        messages.append({"ping": {"id": int(view.check()[8:], 16)}})
    if view.clock == "lockstep":
        messages.append({"done": {"cycle": view.cycle}})
    return messages


class Straight(Bot):
    """Sends its units straight to their zone, or, where the match has none, to fight on the other side of the map.

    Who was stopped steps aside, the farther the more often that happened. Buildings train what they can pay for.
    """

    name = "straight.py"

    def on_start(self, view):
        self.random = random.Random(view.seat)
        self.tries = {}  # by handle
        objective = view.rules["objective"]
        zones = objective["race"]["zones"] if "race" in objective else []
        self.zone = next((zone for zone in zones if zone["seat"] == view.seat), None)

    def on_cycle(self, view):
        for thing in view.mine():
            unit_type = view.type_of(thing)
            if unit_type["speed"] > 0:
                if not (thing.is_moving or thing.own["task"] == "attack_move" or self.is_there(view, thing)):
                    self.send(view, thing, unit_type)
            elif thing.own["training"] is None:
                for each in unit_type["trains"]:
                    if view.rules["unit_types"][each]["making"]["cost"] <= view.stock:
                        self.train(thing.handle, each)
                        break

    def is_there(self, view, thing):
        if self.zone is None:
            return False
        x, y = view.position(thing)
        (left, top), (right, bottom) = self.zone["min"], self.zone["max"]
        return left <= x <= right and top <= y <= bottom

    def send(self, view, thing, unit_type):
        x, y = view.position(thing)
        tries = self.tries[thing.handle] = self.tries.get(thing.handle, 0) + 1
        if self.zone is not None:
            low, high = self.zone["min"], self.zone["max"]
            goal = [self.random.uniform(a, b) for a, b in zip(low, high)]
        else:
            goal = [view.width - x, view.height - y]
        reach = min(tries, 8)
        aside = [within(x + self.random.uniform(-reach, reach), view.width),
                 within(y + self.random.uniform(-reach, reach), view.height)]
        if tries % 2 == 0:
            self.path(thing.handle, aside, goal)
        elif self.zone is None and unit_type["weapon"]:
            self.attack_move(thing.handle, *goal)
        else:
            self.move(thing.handle, *goal)


def within(value, end):
    return min(max(value, 0.0), end)


def main():
    parser = argparse.ArgumentParser(description="Plays a seat of a match of Maniple.")
    parser.add_argument("host")
    parser.add_argument("port", type=int)
    parser.add_argument("token", nargs="?", default="", help="of the seat, as `maniple serve` prints it")
    parser.add_argument("--match", help="the number of the match, where the server has a lobby")
    parser.add_argument("--binary", action="store_true", help="speak binary frames, not JSON lines")
    parser.add_argument("--conformance", action="store_true", help="tell the server each check")
    options = parser.parse_args()
    try:
        result = play(
            Straight(), options.host, options.port, options.token, options.binary, options.conformance, options.match)
    except Trouble as trouble:
        sys.exit(f"maniple.py: {trouble}")
    shown = ("seat", "winners", "cycles", "hash", "checks")
    print(json.dumps({key: result[key] for key in shown}))


if __name__ == "__main__":
    main()
