#!/usr/bin/env node
/**
 * A client of Maniple in one file, for Node, without packages.
 *
 * As a program it plays one seat: it sends its units straight to their zone, and who is stopped steps aside.
 *
 *     node maniple.mjs HOST PORT [TOKEN] [--binary] [--conformance]
 *
 * As a module it is the start of a bot of your own:
 *
 *     import { Bot, play } from "./maniple.mjs";
 *
 *     class Mine extends Bot {
 *       onCycle(view) {
 *         for (const unit of view.mine()) this.move(unit.object, 10, 20);
 *       }
 *     }
 *     console.log(await play(new Mine(), { host: "127.0.0.1", port: 7171, token: "TOKEN" }));
 *
 * What is on the wire is told in docs/PROTOCOL.md; numbers of sections in this file are those of that document.
 */

import { connect } from "node:net";
import { pathToFileURL } from "node:url";

const PROTOCOL = 3;
const MESSAGE_MAX = 16384; // bytes of a message to the server
const RECONNECTS_MAX = 3; // times that a connection which breaks without a reason is opened again

const MODES = ["normal", "switching", "alternate", "switching_back", "site"];
const ACTIONS = ["none", "gather", "build"];
const TASKS = ["none", "attack", "attack_at", "attack_move", "hold", "gather", "return_load", "build"];

/** Why a client cannot go on. */
export class Trouble extends Error {}

/** The connection broke without a word of the server. */
class Cut extends Error {}

/** What decides. Extend it, override the three `on` methods, and call the orders from within them. */
export class Bot {
  name = "javascript";
  orders = []; // what goes out after `onCycle`

  /** The match begins, or goes on after the connection had broken. The view has rules and terrain, no objects. */
  onStart(view) {}

  /** A cycle has passed: `view` is how it is now, `view.delta` what has changed. */
  onCycle(view) {}

  /** The match is over. */
  onEnd(result) {}

  /** Gives any command of section 4. Its result comes in `view.delta.results` with the number returned. */
  order(name, fields) {
    this.orders.push(fields ? { [name]: fields } : name);
    return this.orders.length - 1;
  }

  move(object, x, y, s = null, queue = false) {
    return this.order("move", { object, x, y, s, queue });
  }

  path(object, ...points) {
    return this.order("path", { object, points: points.map(([x, y]) => [x, y, null]) });
  }

  stop(object) {
    return this.order("stop", { object });
  }

  attack(object, target) {
    return this.order("attack", { object, target });
  }

  attackMove(object, x, y) {
    return this.order("attack_move", { object, x, y });
  }

  gather(object, patch) {
    return this.order("gather", { object, patch });
  }

  build(object, unitType, x, y) {
    return this.order("build", { object, unit_type: unitType, x, y });
  }

  train(object, unitType) {
    return this.order("train", { object, unit_type: unitType });
  }

  resign() {
    return this.order("resign");
  }
}

/** What the player knows, kept up to date with the deltas of the server and compared after each. */
export class View {
  constructor(welcome) {
    this.welcome = welcome;
    this.forget();
  }

  /** Starts anew: the next delta is a keyframe. */
  forget() {
    const { seat, rules, clock, cycle, terrain } = this.welcome;
    this.objects = new Map(); // by handle; an object has the fields of `appeared` in section 6
    this.stock = 0;
    this.delta = null; // the last one
    this.sum = new Sum();
    Object.assign(this, { seat, rules, clock, cycle, width: terrain.width, height: terrain.height });
    this.tiles = terrain.tiles.map((row) => [...row]); // tiles[y][x]
    this.walls = [...terrain.segments];
    this.visible = rules.fog ? new Uint8Array(terrain.width * terrain.height) : null;
  }

  /** Returns the own objects, by handle. */
  mine() {
    return [...this.objects.values()].filter((each) => each.owner === this.seat).sort((a, b) => a.object - b.object);
  }

  typeOf(thing) {
    return this.rules.unit_types[thing.unit_type];
  }

  /** Returns where an object is now: section 7, to the server's bits. */
  position({ base }) {
    const passed = this.cycle - base.cycle - base.fraction;
    return [base.point[0] + base.velocity[0] * passed, base.point[1] + base.velocity[1] * passed];
  }

  isVisible(x, y) {
    return this.visible === null || this.visible[y * this.width + x] === 1;
  }

  /** Changes the view by a delta, and compares its hash. */
  apply(delta) {
    this.delta = delta;
    this.cycle = delta.cycle;
    this.stock = delta.stock ?? this.stock;
    this.#applyGround(delta);
    for (const handle of [...delta.vanished, ...delta.died]) {
      this.sum.subtract(hashOf(this.#known(handle)));
      this.objects.delete(handle);
    }
    for (const { object, base } of delta.moved) this.#change(object, { base });
    for (const { object, point, cycle, fraction } of delta.stopped) {
      this.#change(object, { base: { point, cycle, fraction, velocity: [0, 0] } });
    }
    for (const { object, status, own } of delta.changed) {
      this.#change(object, { ...(status && { status }), ...(own && { own }) });
    }
    for (const appeared of delta.appeared) {
      this.objects.set(appeared.object, { ...appeared });
      this.sum.add(hashOf(appeared));
    }
    if (this.check() !== delta.check) {
      throw new Trouble(
        `after the delta of cycle ${this.cycle} the view hashes to ${this.check()}, the server's to ${delta.check}`,
      );
    }
  }

  /** Returns the hash of the view: section 8. */
  check() {
    const { high, low } = new Packer().u32(this.cycle).u32(this.stock).u32(this.sum.low).u32(this.sum.high).fnv();
    return hex32(high) + hex32(low);
  }

  #known(handle) {
    const thing = this.objects.get(handle);
    if (!thing) throw new Trouble(`the delta of cycle ${this.cycle} changes object ${handle}, which is not in the view`);
    return thing;
  }

  #change(handle, fields) {
    const thing = this.#known(handle);
    this.sum.subtract(hashOf(thing));
    Object.assign(thing, fields);
    this.sum.add(hashOf(thing));
  }

  #applyGround({ sight, revealed, walls }) {
    let at = 0;
    for (const [skip, count] of sight) {
      for (let tile = at + skip; tile < at + skip + count; tile++) {
        this.visible[tile] ^= 1;
        const hash = hashOfTile(tile, "*");
        if (this.visible[tile]) this.sum.add(hash);
        else this.sum.subtract(hash);
      }
      at += skip + count;
    }
    for (const [x, y, tiles] of revealed) {
      [...tiles].forEach((tile, offset) => {
        this.tiles[y][x + offset] = tile;
        this.sum.add(hashOfTile(y * this.width + x + offset, tile));
      });
    }
    for (const wall of walls) {
      this.walls.push(wall);
      this.sum.add(wall.reduce((packer, each) => packer.f64(each), new Packer()).fnv());
    }
  }
}

/** A sum modulo 2^64, in two halves: doubles are exact to 2^53 only, and BigInt is slow. */
class Sum {
  high = 0;
  low = 0;

  add({ high, low }) {
    const sum = this.low + low;
    this.high = (this.high + high + (sum > 0xffffffff ? 1 : 0)) >>> 0;
    this.low = sum >>> 0;
  }

  subtract({ high, low }) {
    const difference = this.low - low;
    this.high = (this.high - high - (difference < 0 ? 1 : 0)) >>> 0;
    this.low = difference >>> 0;
  }
}

/** Bytes that are hashed. All packers share one buffer, so that each is used up before the next. */
class Packer {
  static #view = new DataView(new ArrayBuffer(128));
  #at = 0;

  u8(value) {
    Packer.#view.setUint8(this.#at, value);
    this.#at += 1;
    return this;
  }

  u16(value) {
    Packer.#view.setUint16(this.#at, value ?? 0xffff, true);
    this.#at += 2;
    return this;
  }

  u32(value) {
    Packer.#view.setUint32(this.#at, value ?? 0xffffffff, true);
    this.#at += 4;
    return this;
  }

  f64(value) {
    Packer.#view.setFloat64(this.#at, value, true);
    this.#at += 8;
    return this;
  }

  /**
   * Returns FNV-1a with 64 bits (Fowler, Noll and Vo, 1991). The prime is 2^40 + 0x1b3: the low half times 0x1b3 stays
   * below 2^53, and times 2^40 it is a shift into the high half.
   */
  fnv() {
    let high = 0xcbf29ce4;
    let low = 0x84222325;
    for (let at = 0; at < this.#at; at++) {
      low = (low ^ Packer.#view.getUint8(at)) >>> 0;
      const product = low * 0x1b3;
      high = (Math.imul(high, 0x1b3) + Math.floor(product / 0x100000000) + (low << 8)) >>> 0;
      low = product >>> 0;
    }
    return { high, low };
  }
}

function hashOf({ object, unit_type, owner, base, status, own }) {
  const packer = new Packer().u32(object).u16(unit_type).u16(owner);
  packer.f64(base.point[0]).f64(base.point[1]).u32(base.cycle).f64(base.fraction);
  packer.f64(base.velocity[0]).f64(base.velocity[1]).u32(status.hit_points).u32(status.amount);
  packer.u8(MODES.indexOf(status.mode)).u8(ACTIONS.indexOf(status.action));
  if (own) {
    packer.u32(own.queued).u8(TASKS.indexOf(own.task)).u32(own.load).u32(own.ready);
    packer.u16(own.training).u32(own.waiting).u32(own.due);
  }
  return packer.fnv();
}

function hashOfTile(number, tile) {
  return new Packer().u32(number).u8(tile.charCodeAt(0)).fnv();
}

function hex32(value) {
  return value.toString(16).padStart(8, "0");
}

// --- binary: section 3. Values are the ones that JSON gives, so nothing else here minds which of the two is spoken.

/** The bytes of a message that are left to read. */
class Body {
  constructor(data) {
    this.data = data;
    this.at = 0;
  }

  /** Returns the place of the next `count` bytes. */
  take(count) {
    this.at += count;
    if (this.at > this.data.length) throw new Trouble("the server sent a message that ends too early");
    return this.at - count;
  }
}

/** A type: `read(body)` returns a value, `write(value)` a list of buffers. */
const kind = (read, write) => ({ read, write });

const double = kind(
  (body) => body.data.readDoubleLE(body.take(8)),
  (value) => {
    const bytes = Buffer.alloc(8);
    bytes.writeDoubleLE(value);
    return [bytes];
  },
);
const byte = kind((body) => body.data[body.take(1)], (value) => [Buffer.from([value])]);
const flag = kind((body) => byte.read(body) === 1, (value) => byte.write(value ? 1 : 0));

/** A varint as a number, which is exact to 2^53: nothing but a digest is above. */
const uint = kind(
  (body) => {
    const first = byte.read(body);
    if (first < 251) return first;
    if (first === 251) return body.data.readUInt16LE(body.take(2));
    if (first === 252) return body.data.readUInt32LE(body.take(4));
    return Number(body.data.readBigUInt64LE(body.take(8)));
  },
  (value) => {
    if (value < 251) return [Buffer.from([value])];
    const bytes = Buffer.alloc(value < 65536 ? 3 : 5);
    bytes[0] = value < 65536 ? 251 : 252;
    bytes.writeUIntLE(value, 1, bytes.length - 1);
    return [bytes];
  },
);
const digest = kind((body) => {
  const wide = body.data[body.at] === 253;
  if (wide) body.take(1);
  return (wide ? body.data.readBigUInt64LE(body.take(8)) : uint.read(body)).toString(16).padStart(16, "0");
}, (value) => {
  const bytes = Buffer.alloc(9, 253);
  bytes.writeBigUInt64LE(BigInt(`0x${value}`), 1);
  return [bytes];
});
const bytes = kind(
  (body) => {
    const length = uint.read(body);
    const at = body.take(length);
    return body.data.subarray(at, at + length);
  },
  (value) => [...uint.write(value.length), value],
);
const text = kind(
  (body) => bytes.read(body).toString(),
  (value) => bytes.write(Buffer.from(value)),
);
const list = (item) =>
  kind(
    (body) => {
      const values = [];
      for (let left = uint.read(body); left > 0; left--) values.push(item.read(body));
      return values;
    },
    (values) => [...uint.write(values.length), ...values.flatMap(item.write)],
  );
const option = (item) =>
  kind(
    (body) => (flag.read(body) ? item.read(body) : null),
    (value) => (value == null ? flag.write(false) : [...flag.write(true), ...item.write(value)]),
  );
const sequence = (...items) =>
  kind(
    (body) => items.map((item) => item.read(body)),
    (values) => items.flatMap((item, place) => item.write(values[place])),
  );
const record = (fields) =>
  kind(
    (body) => {
      const value = {};
      for (const name in fields) value[name] = fields[name].read(body);
      return value;
    },
    (value) => Object.keys(fields).flatMap((name) => fields[name].write(value[name])),
  );
/** A choice of variants, in the order of the document; those without fields have `null`. */
const choice = (variants) => {
  const names = Object.keys(variants);
  return kind(
    (body) => {
      const name = names[uint.read(body)];
      if (name === undefined) throw new Trouble("the server sent a tag that is not known");
      return variants[name] ? { [name]: variants[name].read(body) } : name;
    },
    (value) => {
      const name = typeof value === "string" ? value : Object.keys(value)[0];
      const fields = variants[name] ? variants[name].write(value[name]) : [];
      return [...uint.write(names.indexOf(name)), ...fields];
    },
  );
};
const names = (...all) => choice(Object.fromEntries(all.map((name) => [name, null])));

const uints = list(uint);
const point = sequence(double, double);
const start = option(sequence(uint, double));
const unit = record({ object: uint });
const unitTo = record({ object: uint, x: double, y: double });
const command = choice({
  move: record({ object: uint, x: double, y: double, s: option(double), queue: flag, start }),
  path: record({ object: uint, points: list(sequence(double, double, option(double))), start }),
  stop: unit, resign: null, attack: record({ object: uint, target: uint }), attack_at: unitTo, attack_move: unitTo,
  hold: unit, gather: record({ object: uint, patch: uint }), return_load: unit,
  build: record({ object: uint, unit_type: uint, x: double, y: double }),
  train: record({ object: uint, unit_type: uint }), cancel: unit, switch: unit,
});
const fromClient = choice({
  hello: record({ protocol: uint, client: text, player: text, token: text }),
  commands: record({ seen_cycle: uint, list: list(record({ seq: uint, command })) }),
  done: record({ cycle: uint }), ping: record({ id: uint }), pause: record({ on: flag }),
  watch: record({ protocol: uint, client: text, view: choice({ everything: null, seat: uint }) }),
  list: record({ protocol: uint }),
  create: record({ protocol: uint, scenario: text, clock: names("realtime", "lockstep"), open: flag }),
  enter: record({ match: digest, seat: option(uint) }),
});

const layer = names("ground", "air");
const weapon = record({
  range: double, range_min: double, cooldown: uint, damage_min: uint, damage_max: uint,
  splash: option(record({ radius: double, falloff: names("none", "linear") })), targets: list(layer),
});
const unitType = record({
  name: text,
  shape: choice({ circle: record({ radius: double }), rectangle: record({ width: double, height: double }) }),
  layer, speed: double, sight: double, hit_points: option(uint), armor: uint, weapon: option(weapon),
  alternate: option(record({ name: text, switch_cycles: uint, speed: double, armor: uint, weapon: option(weapon) })),
  harvest: option(record({ load_max: uint, cycles_each: uint })), patch_places: option(uint), takes_loads: flag,
  making: record({ cost: uint, cycles: uint, requires: uints }), trains: uints, builds: uints,
});
const rules = record({
  scenario: text, cycles_max: uint, players: list(text), unit_types: list(unitType),
  stops: names("both", "approaching"), skin: double, waypoints_max: uint, commands_a_cycle_max: uint,
  objective: choice({
    race: record({ zones: list(record({ seat: uint, min: point, max: point })) }),
    resources: record({ goal: option(uint) }), kills: null, buildings: null, last_standing: null,
    survive: record({ team: uint }),
  }),
  teams: uints, friendly_fire: flag, objects_max: uint, training_max: uint, fog: flag,
  terrain: names("known", "explored"), walls_block: flag, identity: names("fresh", "persistent"),
  positions: choice({ exact: null, grid: record({ bits: byte }) }),
});
const wall = sequence(double, double, double, double);
const welcome = record({
  match: digest, seat: option(uint), delay: option(uint), seats: uint, cycle: uint, rate: double, clock: names("realtime", "lockstep"), rules,
  terrain: record({ width: uint, height: uint, tiles: list(text), segments: list(wall) }),
});
const limit = record({ limit: uint });
const refused = choice({
  protocol: record({ supported: uint }), handshake: null, timeout: record({ seconds: uint }), name_too_long: limit,
  token: null, full: null, replaced: null, malformed: record({ place: text, problem: text }), too_large: limit,
  too_slow: null, shutdown: null, no_spectators: null, seats_only: null, no_such_seat: record({ seats: uint }),
  spectators_full: limit, spectator: null, held_too_much: null, broken: null, no_match: null, no_scenario: null,
  matches_full: limit, address_full: limit, draining: null, not_begun: record({ seconds: uint }), asks_too_much: limit, operator: null, too_many_commands: limit,
});
const tally = record({
  units: uint, arrived: uint, arrival_sum: uint, gathered: uint, made: uint, units_destroyed: uint,
  buildings_destroyed: uint, units_lost: uint, buildings_lost: uint, last_building: uint,
});
const result = record({
  winners: uints, reason: names("objective", "length", "resigned"), cycles: uint,
  scores: list(record({ seat: uint, name: text, team: uint, points: uint, tally, resigned: flag })), hash: digest,
});
const max = record({ max: uint });
const refusal = choice({
  unknown_handle: null, out_of_world: record({ width: uint, height: uint }),
  bad_number: record({ field: text, problem: text }), too_fast: record({ max: double }), unknown_action: null,
  too_many_waypoints: max, empty_path: null, too_many_commands: max, start_in_past: record({ now: uint }), out: null,
  unknown_target: null, bad_target: null, busy: null, not_affordable: record({ cost: uint, stock: uint }),
  missing: record({ unit_type: uint }), training_full: max, too_many_objects: max, nothing_to_cancel: null,
  bad_place: null, nothing_to_return: null,
});
const outcome = choice({ applied: record({ cycle: uint, late: uint }), refused: record({ reason: refusal }) });
const base = record({ point, cycle: uint, fraction: double, velocity: point });
const task = names(...TASKS);
const status = record({
  hit_points: option(uint), amount: option(uint), mode: names(...MODES), action: names(...ACTIONS),
});
const own = option(
  record({ queued: uint, task, load: uint, ready: uint, training: option(uint), waiting: uint, due: option(uint) }),
);
const stopReason = choice({
  arrived: null, ordered: null, object: record({ other: option(uint) }), segment: null, edge: null,
});
const why = names("done", "blocked", "lost", "empty", "no_room", "not_affordable", "missing", "too_many");
const seen = { object: uint, unit_type: uint, owner: option(uint) };
const before = {
  results: list(record({ seq: uint, outcome })), sight: list(sequence(uint, uint)),
  revealed: list(sequence(uint, uint, text)), walls: list(wall),
};
const after = {
  vanished: uints, died: uints, changed: list(record({ object: uint, status: option(status), own })),
  shots: list(record({ object: uint, target: option(uint) })), ended: list(record({ object: uint, task, why })),
  stock: option(uint),
};
const delta = record({
  cycle: uint, ...before, appeared: list(record({ ...seen, base, status, own })),
  moved: list(record({ object: uint, base })),
  stopped: list(record({ object: uint, point, cycle: uint, fraction: double, reason: option(stopReason) })),
  ...after, check: digest,
});
const rest = option(record({ ...before, appeared: list(record({ ...seen, status, own })), ...after }));
const packed = record({ cycle: uint, rest, motions: bytes, check: digest });
const listed = record({
  match: digest, scenario: text, clock: names("realtime", "lockstep"), rate: double, has_begun: flag,
  seats: list(record({ open: flag, taken: flag })), spectators: option(record({ everything: flag, delay: uint })),
});
const fromServer = choice({
  welcome, refused: record({ reason: refused }), delta, pong: record({ id: uint, cycle: uint, fraction: double }),
  ended: record({ result }), packed, paused: record({ seats: uints, on: flag }),
  matches: record({ scenarios: list(text), list: list(listed) }), created: record({ match: digest, tokens: list(text) }),
  keyframe: record({}), warned: record({ reason: refused, left: uint }),
});

/** Returns the delta that a packed one stands for: section 6, *Packed*. */
function unpacked({ cycle, rest, motions: data, check }, view) {
  const nothing = { results: [], sight: [], revealed: [], walls: [], appeared: [], vanished: [], died: [], changed: [],
    shots: [], ended: [], stock: null };
  const motions = new Motions(data, cycle, view);
  const delta = { ...(rest ?? nothing), cycle, check };
  delta.appeared = delta.appeared.map((each) => ({ ...each, base: motions.motion(each.unit_type, null) }));
  delta.moved = motions.moved();
  delta.stopped = motions.stopped();
  return delta;
}

/** The motions of a packed delta, which leave out what the view can tell. */
class Motions extends Body {
  static #reasons = [null, "arrived", "ordered", "segment", "edge"];
  static #scratch = new DataView(new ArrayBuffer(8));

  constructor(data, cycle, view) {
    super(data);
    this.cycle = cycle;
    this.view = view;
    const grid = view.rules.positions.grid;
    this.step = grid ? 2 ** -grid.bits : null; // of points; null: positions are exact
    this.pace = grid ? this.step / 256 : null; // of velocities
  }

  moved() {
    const moved = [];
    let object = -1;
    for (let left = this.data.length > 0 ? this.unsigned() : 0; left > 0; left--) {
      object += 1 + this.unsigned();
      const thing = this.view.objects.get(object);
      moved.push({ object, base: this.motion(thing.unit_type, thing.base) });
    }
    return moved;
  }

  stopped() {
    const stopped = [];
    let object = -1;
    while (this.at < this.data.length) {
      object += 1 + this.unsigned();
      const flags = byte.read(this);
      const spot = this.spot(flags, this.view.objects.get(object).base);
      const why = flags >> 4;
      const other = why === 6 ? this.unsigned() : null;
      stopped.push({ object, ...spot, reason: why < 5 ? Motions.#reasons[why] : { object: { other } } });
    }
    return stopped;
  }

  motion(unitType, before) {
    const flags = byte.read(this);
    const spot = this.spot(flags, before);
    const how = (flags >> 4) & 3;
    if (how === 0) return { ...spot, velocity: [this.number(this.pace), this.number(this.pace)] };
    if (how === 3) return { ...spot, velocity: [0, 0] };
    const type = this.view.rules.unit_types[unitType];
    const { speed } = how === 1 ? type : type.alternate;
    const given = this.number(this.pace);
    const follows = Math.sqrt(Math.max(speed * speed - given * given, 0));
    let other = this.differing(this.near(follows, this.pace), this.pace);
    if (flags & 128) other = -other;
    return { ...spot, velocity: flags & 64 ? [other, given] : [given, other] };
  }

  spot(flags, before) {
    const ago = [1, 1, 0][flags & 3] ?? this.unsigned();
    let fraction = 0;
    if (flags & 1) fraction = this.step === null ? double.read(this) : this.unsigned() / 256;
    const where = (flags >> 2) & 3;
    let point;
    if (where === 2) {
      point = [this.number(this.step), this.number(this.step)];
    } else {
      const time = this.cycle - ago - before.cycle - before.fraction + fraction;
      point = before.point.map((p, axis) => this.near(p + before.velocity[axis] * time, this.step));
      if (where === 1) point = point.map((each) => this.differing(each, this.step));
    }
    return { point, cycle: this.cycle - ago, fraction };
  }

  number(step) {
    return step === null ? double.read(this) : Number(this.signed()) * step;
  }

  near(value, step) {
    return step === null ? value : Math.floor(value / step + 0.5) * step;
  }

  /** Returns the number that is so many steps away, or so many doubles. */
  differing(value, step) {
    const difference = this.signed();
    if (step !== null) return value + Number(difference) * step;
    const turned = (bits) => (bits >= 0n ? bits : bits ^ 0x7fffffffffffffffn); // the doubles in order, and back
    const scratch = Motions.#scratch;
    scratch.setFloat64(0, value);
    scratch.setBigInt64(0, turned(BigInt.asIntN(64, turned(scratch.getBigInt64(0)) + difference)));
    return scratch.getFloat64(0);
  }

  unsigned() {
    return Number(this.wide());
  }

  signed() {
    const value = this.wide();
    return (value >> 1n) ^ -(value & 1n);
  }

  wide() {
    let value = 0n;
    for (let shift = 0n; ; shift += 7n) {
      const next = byte.read(this);
      value |= BigInt(next & 127) << shift;
      if (next < 128) return value;
    }
  }
}

// --- the connection

/** One connection: messages in both directions. */
class Link {
  #preamble;

  constructor({ host, port, binary }) {
    this.binary = binary;
    this.#preamble = binary ? [Buffer.from("MNPL")] : [];
    this.socket = connect({ host, port, noDelay: true });
    this.socket.on("error", () => {}); // told by `messages`
  }

  encode(message) {
    return this.binary ? Buffer.concat(fromClient.write(message)) : Buffer.from(JSON.stringify(message));
  }

  /** Sends messages in one write. */
  say(...messages) {
    const parts = this.#preamble;
    this.#preamble = [];
    for (const body of messages.map((message) => this.encode(message))) {
      const length = Buffer.alloc(4);
      length.writeUInt32LE(body.length);
      parts.push(...(this.binary ? [length, body] : [body, Buffer.from("\n")]));
    }
    this.socket.write(Buffer.concat(parts));
  }

  /** Yields each message as [name, fields]. */
  async *messages() {
    try {
      for await (const body of this.binary ? this.#frames() : this.#lines()) {
        const message = this.binary ? fromServer.read(new Body(body)) : JSON.parse(body);
        yield Object.entries(message)[0];
      }
    } catch (error) {
      if (error.code === "ECONNREFUSED" || error.code === "ENOTFOUND") throw new Trouble(error.message);
      throw error.code ? new Cut() : error; // what has a code comes from the socket
    }
    throw new Cut();
  }

  close() {
    this.socket.destroy();
  }

  /** Returns the messages that it takes to give these numbered orders, none of them too long. */
  commands(cycle, orders) {
    if (orders.length === 0) return [];
    const message = { commands: { seen_cycle: cycle, list: orders } };
    if (orders.length === 1 || this.encode(message).length <= MESSAGE_MAX) return [message];
    const half = orders.length >> 1;
    return [...this.commands(cycle, orders.slice(0, half)), ...this.commands(cycle, orders.slice(half))];
  }

  /** Yields the bodies of frames: a length of 4 bytes, then so many bytes. */
  async *#frames() {
    let rest = Buffer.alloc(0);
    for await (const piece of this.socket) {
      rest = Buffer.concat([rest, piece]);
      while (rest.length >= 4 && rest.length >= 4 + rest.readUInt32LE(0)) {
        const end = 4 + rest.readUInt32LE(0);
        yield rest.subarray(4, end);
        rest = rest.subarray(end);
      }
    }
  }

  async *#lines() {
    let rest = "";
    this.socket.setEncoding("utf8");
    for await (const piece of this.socket) {
      const lines = (rest + piece).split("\n");
      rest = lines.pop();
      yield* lines;
    }
  }
}

/**
 * Plays a match to its end; returns its result, and as `checks` how many times the two views agreed.
 *
 * With `conformance` it tells the server the low half of each check, as `maniple conformance serve` wants to see.
 */
export async function play(bot, { host, port, token = "", binary = false, conformance = false, match = null }) {
  let checks = 0;
  for (let connection = 0; connection <= RECONNECTS_MAX; connection++) {
    const link = new Link({ host, port, binary });
    let view = null;
    try {
      if (match !== null) link.say({ enter: { match, seat: null } });
      link.say({ hello: { protocol: PROTOCOL, client: "maniple.mjs 1.0", player: bot.name, token } });
      for await (const [name, fields] of link.messages()) {
        if (name === "welcome") {
          view = new View(fields);
          bot.onStart(view);
        } else if (name === "delta" || name === "packed") {
          view.apply(name === "delta" ? fields : unpacked(fields, view));
          checks += 1;
          link.say(...answer(link, view, bot, conformance));
        } else if (name === "refused") {
          throw new Trouble(`the server refused: ${JSON.stringify(fields.reason)}`);
        } else if (name === "ended") {
          bot.onEnd(fields.result);
          return { ...fields.result, seat: view.seat, checks };
        } else if (name === "keyframe") {
          view.forget();
        } else if (name === "warned") {
          console.error(`the server warns: ${JSON.stringify(fields.reason)}`);
        } // `pong` and `paused` need no answer.
      }
    } catch (error) {
      if (!(error instanceof Cut)) throw error;
      if (view === null || token === "") break;
      await new Promise((wake) => setTimeout(wake, 200)); // the server lets nobody in more often
    } finally {
      link.close();
    }
  }
  throw new Trouble("the server closed the connection without a word");
}

/** Returns what is to be said about the present view. */
function answer(link, view, bot, conformance) {
  bot.orders = [];
  bot.onCycle(view);
  const orders = bot.orders.map((each, seq) => ({ seq, command: each }));
  const messages = link.commands(view.cycle, orders);
  if (conformance) messages.push({ ping: { id: parseInt(view.check().slice(8), 16) } });
  if (view.clock === "lockstep") messages.push({ done: { cycle: view.cycle } });
  return messages;
}

/**
 * Sends its units straight to their zone, or, where the match has none, to fight on the other side of the map.
 *
 * Who was stopped steps aside, the farther the more often that happened. Buildings train what they can pay for.
 */
export class Straight extends Bot {
  name = "straight.mjs";
  #tries = new Map(); // by handle
  #seed = 1;

  onStart(view) {
    this.#seed = view.seat + 1;
    this.zone = view.rules.objective.race?.zones.find((zone) => zone.seat === view.seat);
  }

  onCycle(view) {
    for (const thing of view.mine()) {
      const type = view.typeOf(thing);
      if (type.speed > 0) {
        const isMoving = thing.base.velocity.some((each) => each !== 0);
        if (!isMoving && thing.own.task !== "attack_move" && !this.#isThere(view, thing)) this.#send(view, thing, type);
      } else if (thing.own.training === null) {
        const affordable = type.trains.find((each) => view.rules.unit_types[each].making.cost <= view.stock);
        if (affordable !== undefined) this.train(thing.object, affordable);
      }
    }
  }

  #isThere(view, thing) {
    const [x, y] = view.position(thing);
    const zone = this.zone;
    return zone !== undefined && zone.min[0] <= x && x <= zone.max[0] && zone.min[1] <= y && y <= zone.max[1];
  }

  #send(view, thing, type) {
    const [x, y] = view.position(thing);
    const tries = (this.#tries.get(thing.object) ?? 0) + 1;
    this.#tries.set(thing.object, tries);
    const goal = this.zone
      ? [this.#between(this.zone.min[0], this.zone.max[0]), this.#between(this.zone.min[1], this.zone.max[1])]
      : [view.width - x, view.height - y];
    const reach = Math.min(tries, 8);
    const near = (from, end) => Math.min(Math.max(this.#between(from - reach, from + reach), 0), end);
    if (tries % 2 === 0) this.path(thing.object, [near(x, view.width), near(y, view.height)], goal);
    else if (!this.zone && type.weapon) this.attackMove(thing.object, ...goal);
    else this.move(thing.object, ...goal);
  }

  /** Returns a number that looks random, and is the same in each run (Park and Miller, 1988). */
  #between(low, high) {
    this.#seed = (this.#seed * 48271) % 0x7fffffff;
    return low + (high - low) * (this.#seed / 0x7fffffff);
  }
}

async function main() {
  const isFlag = (word) => word.startsWith("--");
  const [host, port, token = ""] = process.argv.slice(2).filter((word) => !isFlag(word));
  const flags = process.argv.slice(2).filter(isFlag);
  const chosen = flags.find((word) => word.startsWith("--match="));
  const isKnown = (word) => word === chosen || ["--binary", "--conformance"].includes(word);
  if (port === undefined || !flags.every(isKnown)) {
    throw new Trouble("usage: node maniple.mjs HOST PORT [TOKEN] [--match=NUMBER] [--binary] [--conformance]");
  }
  const match = chosen === undefined ? null : chosen.slice("--match=".length);
  const binary = flags.includes("--binary");
  const conformance = flags.includes("--conformance");
  const { seat, winners, cycles, hash, checks } = await play(new Straight(), {
    host, port: Number(port), token, binary, conformance, match,
  });
  console.log(JSON.stringify({ seat, winners, cycles, hash, checks }));
}

if (process.argv[1] && import.meta.url === pathToFileURL(process.argv[1]).href) {
  main().catch((error) => {
    console.error(error instanceof Trouble ? `maniple.mjs: ${error.message}` : error);
    process.exitCode = 1;
  });
}
