"""Reads the motions of a packed delta (section 6 of PROTOCOL.md); run with a file of vectors, checks them."""
import json, math, struct, sys


def motions(data, cycle, bits, speeds, known, appeared):
    """Returns the bases of the appeared, and what moved and stopped by handle.

    bits: of the grid, None for exact positions; speeds: by unit type, of both modes; known: by handle, unit type and base before
    the delta; appeared: unit types in the order of the delta. A base is (x, y, cycle, fraction, vx, vy)."""
    at = 0
    place, pace = (None, None) if bits is None else (2.0**-bits, 2.0 ** -(bits + 8))

    def take(count):
        nonlocal at
        at += count
        return data[at - count : at]

    def unsigned():
        number, shift = 0, 0
        while True:
            byte = take(1)[0]
            number |= (byte & 127) << shift
            shift += 7
            if byte < 128:
                return number

    def signed():
        number = unsigned()
        return number >> 1 ^ -(number & 1)

    def number(step):
        return struct.unpack("<d", take(8))[0] if step is None else signed() * step

    def beyond(start, step):  # the number that is so many doubles or steps away
        if step is not None:
            return start + signed() * step
        rank = struct.unpack("<q", struct.pack("<d", start))[0]
        rank = (rank if rank >= 0 else rank ^ 2**63 - 1) + signed()
        rank = (rank + 2**63) % 2**64 - 2**63
        return struct.unpack("<d", struct.pack("<q", rank if rank >= 0 else rank ^ 2**63 - 1))[0]

    def near(x, step):
        return x if step is None else math.floor(x / step + 0.5) * step

    def spot(flags, before):
        ago = (1, 1, 0, None)[flags & 3]
        ago = unsigned() if ago is None else ago
        part = 0.0 if flags & 3 in (0, 2) else number(None) if bits is None else unsigned() / 256
        if flags >> 2 & 3 == 2:
            return number(place), number(place), cycle - ago, part
        x, y, start, fraction, vx, vy = before
        time = float(cycle - ago - start) - fraction + part
        point = [near(x + vx * time, place), near(y + vy * time, place)]
        if flags >> 2 & 3 == 1:
            point = [beyond(each, place) for each in point]
        return point[0], point[1], cycle - ago, part

    def base(kind, before):
        flags = take(1)[0]
        start, how = spot(flags, before), flags >> 4 & 3
        if how == 0 or how == 3:
            return start + ((number(pace), number(pace)) if how == 0 else (0.0, 0.0))
        speed, given = speeds[kind][how - 1], number(pace)
        other = beyond(near(math.sqrt(max(speed * speed - given * given, 0.0)), pace), pace)
        other = -other if flags & 128 else other
        return start + ((other, given) if flags & 64 else (given, other))

    new, moved, stopped, handle = [base(kind, None) for kind in appeared], {}, {}, -1
    for _ in range(unsigned() if at < len(data) else 0):
        handle += 1 + unsigned()
        moved[handle] = base(*known[handle])
    handle = -1
    while at < len(data):
        handle += 1 + unsigned()
        flags = take(1)[0]
        stopped[handle] = spot(flags, known[handle][1]) + (0.0, 0.0), flags >> 4, unsigned() if flags >> 4 == 6 else None
    return new, moved, stopped


if __name__ == "__main__":
    cases = json.load(open(sys.argv[1]))
    for case in cases:
        known = {int(handle): each for handle, each in case["known"].items()}
        data = bytes.fromhex(case["motions"])
        found = motions(data, case["cycle"], case["bits"], case["speeds"], known, case["appeared"])
        if json.loads(json.dumps(found)) != case["expected"]:
            sys.exit(f"{case['name']}: found {found}, expected {case['expected']}")
    print(f"{len(cases)} cases agree")
