//! One instruction as the emulator disassembles it: its timing class, and the registers that a stall depends on.

use anyhow::{Context, Result, ensure};

/// Bits of `r0` … `r15`, of `s0` … `s31` above them, and of the flags of the floating-point unit.
pub type Registers = u64;

const SINGLES: u32 = 16;
const FLOAT_FLAGS: Registers = 1 << 48;
const PC: Registers = 1 << 15;

/// The rows of the table of timings in the manual of the processor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    /// Integer, with its cycles.
    Integer(u64),
    /// An `IT` that is folded into a 16-bit instruction before it.
    Condition,
    /// One loaded word, which the next load or store overlaps.
    Load,
    /// One stored word of an integer register at an immediate offset, which the next instruction overlaps.
    Store,
    /// One stored word otherwise.
    SlowStore,
    /// So many words at once.
    Several(u64),
    /// Arithmetic of the floating-point unit, with its cycles.
    Float(u64),
    /// A division or square root, which integer instructions overlap.
    Divide,
    /// A move from or to the floating-point unit.
    Move,
}

/// Where the program may go on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Jump {
    None,
    /// To an address in the instruction.
    Direct,
    /// To an address of a register or of memory.
    Indirect,
}

/// An instruction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Instruction {
    pub address: u32,
    /// 2 or 4.
    pub bytes: u32,
    pub class: Class,
    pub jump: Jump,
    /// Whether the event register is set: the counter of the firmware does so at the start and end of what it counts.
    pub is_mark: bool,
    /// Those of the address of a load or store.
    pub address_of: Registers,
    pub reads: Registers,
    pub writes: Registers,
    /// The address of a constant between the code.
    pub literal: Option<u32>,
}

impl Instruction {
    /// Reads a line such as `0x0800f9c4:  ca07       ldm      r2, {r0, r1, r2}`.
    pub fn parse(line: &str) -> Result<Self> {
        read(line).with_context(|| format!("not an instruction: {line}"))
    }

    pub const fn end(&self) -> u32 {
        self.address.wrapping_add(self.bytes)
    }

    pub const fn is_float(&self) -> bool {
        const FLOATS: Registers = !0 << SINGLES;
        matches!(self.class, Class::Float(_) | Class::Divide | Class::Move) || (self.reads | self.writes) & FLOATS != 0
    }
}

fn read(line: &str) -> Result<Instruction> {
    let (address, text) = line.split_once(':').context("no address")?;
    let address = u32::from_str_radix(address.trim().trim_start_matches("0x"), 16)?;
    let is_code = |word: &&str| word.len() == 4 && word.bytes().all(|byte| byte.is_ascii_hexdigit());
    let mut words = text.split_whitespace();
    let halves = if words.clone().take(2).filter(is_code).count() == 2 { 2 } else { 1 };
    let name = words.by_ref().nth(halves).context("no name")?;
    let operands = words.collect::<Vec<_>>().join(" ");
    let bytes = 2 * u32::try_from(halves)?;
    let base = name.split('.').next().unwrap_or(name);
    let first = operands.split(',').next().unwrap_or_default();
    let all = registers(&operands);
    let inside = operands.find('[').map_or(0, |at| registers(&operands[at..]));
    let mut read = Instruction {
        address,
        bytes,
        class: class(base, &operands)?,
        jump: jump(base, &operands),
        is_mark: base == "sev",
        address_of: 0,
        reads: all,
        writes: registers(first),
        literal: literal(address, &operands),
    };
    match read.class {
        Class::Load => (read.address_of, read.reads) = (inside, inside),
        Class::Store | Class::SlowStore => (read.address_of, read.writes) = (inside, 0),
        Class::Several(_) => {
            let stack = registers("sp");
            read.address_of = if operands.starts_with('{') { stack } else { inside | base_register(first) };
        }
        _ if base.starts_with("vcmp") => read.writes = FLOAT_FLAGS,
        _ if base.starts_with("vmrs") => read.reads |= FLOAT_FLAGS,
        _ if ["cmp", "cmn", "tst", "teq"].iter().any(|test| base.starts_with(test)) => read.writes = 0,
        _ => {}
    }
    Ok(read)
}

/// The base of `ldm` and `stm`, which comes before a list, and none otherwise.
fn base_register(first: &str) -> Registers {
    if first.contains('{') { 0 } else { registers(first) }
}

/// Starts of names, and their classes; `words` are those of a list in braces. The first one decides.
fn class(base: &str, operands: &str) -> Result<Class> {
    let words = registers(operands[operands.find('{').unwrap_or(0)..].trim_matches(['{', '}'])).count_ones().into();
    let indexed = operands.find('[').is_some_and(|at| registers(&operands[at..]).count_ones() > 1);
    let double = |class| if operands.starts_with('d') { Class::Several(2) } else { class };
    let table: [(&str, Class); 14] = [
        ("vldm vstm vpush vpop ldm stm push pop", Class::Several(words)),
        ("ldrd strd", Class::Several(2)),
        ("vldr", double(Class::Load)),
        ("vstr", double(Class::SlowStore)),
        ("ldr", Class::Load),
        ("str", if indexed { Class::SlowStore } else { Class::Store }),
        ("vdiv vsqrt", Class::Divide),
        ("vmla vmls vnmla vnmls vfma vfms vfnma vfnms", Class::Float(3)),
        ("vmov vmrs vmsr", Class::Move),
        ("vmul vnmul vadd vsub vabs vneg vcmp vcvt", Class::Float(1)),
        ("udiv sdiv", Class::Integer(12)),
        ("mla mls", Class::Integer(2)),
        // The load and the sum before the jump.
        ("tbb tbh", Class::Integer(3)),
        ("it", Class::Condition),
    ];
    let found = table.iter().find(|(starts, _)| starts.split(' ').any(|start| base.starts_with(start)));
    ensure!(found.is_some() || !base.starts_with('v'), "no timing of `{base}`");
    Ok(found.map_or(Class::Integer(1), |(_, class)| *class))
}

fn jump(base: &str, operands: &str) -> Jump {
    let conditions = ["", "eq", "ne", "hs", "lo", "mi", "pl", "vs", "vc", "hi", "ls", "ge", "lt", "gt", "le", "al"];
    let is = |name: &str| base.strip_prefix(name).is_some_and(|condition| conditions.contains(&condition));
    let loads = ["ldr", "pop", "ldm", "mov", "add"].iter().any(|name| base.starts_with(name));
    let first = operands.find('{').map_or_else(|| operands.split(',').next().unwrap_or_default(), |at| &operands[at..]);
    match base {
        "cbz" | "cbnz" => Jump::Direct,
        "tbb" | "tbh" => Jump::Indirect,
        _ if is("b") || is("bl") => Jump::Direct,
        _ if is("bx") || is("blx") || loads && registers(first) & PC != 0 => Jump::Indirect,
        _ => Jump::None,
    }
}

/// The constant of a load such as `[pc, #0x38]`.
fn literal(address: u32, operands: &str) -> Option<u32> {
    let offset = operands.split_once("[pc, #")?.1.trim_end_matches(']');
    let value = |text: &str| match text.strip_prefix("0x") {
        Some(hexadecimal) => u32::from_str_radix(hexadecimal, 16).ok(),
        None => text.parse().ok(),
    };
    let base = address.wrapping_add(4) & !3;
    match offset.strip_prefix('-') {
        Some(offset) => Some(base.wrapping_sub(value(offset)?)),
        None => Some(base.wrapping_add(value(offset)?)),
    }
}

/// The registers that a text names.
fn registers(text: &str) -> Registers {
    text.split(|c: char| !c.is_ascii_alphanumeric() && c != '#').filter_map(register).fold(0, |all, one| all | one)
}

fn register(name: &str) -> Option<Registers> {
    let numbered = |letter: char| name.strip_prefix(letter).and_then(|number| number.parse::<u32>().ok());
    let core = match name {
        "sb" => Some(9),
        "sl" => Some(10),
        "fp" => Some(11),
        "ip" => Some(12),
        "sp" => Some(13),
        "lr" => Some(14),
        "pc" => Some(15),
        _ => numbered('r').filter(|&number| number < 16),
    };
    let single = || numbered('s').filter(|&number| number < 32).map(|number| 1 << (SINGLES + number));
    let double = || numbered('d').filter(|&number| number < 16).map(|number| 0b11 << (SINGLES + 2 * number));
    core.map(|number| 1 << number).or_else(single).or_else(double)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(text: &str) -> Instruction {
        Instruction::parse(&format!("0x08000100:  ca07       {text}")).expect("an instruction")
    }

    #[test]
    fn classes_are_those_of_the_manual() {
        let cases = [
            ("ldm      r2, {r0, r1, r2}", Class::Several(3)),
            ("vstmia   r1, {s3, s4, s5}", Class::Several(3)),
            ("vldr     d8, [r0]", Class::Several(2)),
            ("vldr     s20, [r6, #0x14]", Class::Load),
            ("ldrb.w   r1, [r4, r5]", Class::Load),
            ("str.w    r1, [r4, #8]", Class::Store),
            ("vmlane.f32 s0, s1, s2", Class::Float(3)),
            ("vcvt.f32.u32 s10, s0", Class::Float(1)),
            ("udivne   r0, r1, r2", Class::Integer(12)),
            ("itte     ne", Class::Condition),
        ];
        for (text, class) in cases {
            assert_eq!(parsed(text).class, class, "{text}");
        }
    }

    #[test]
    fn jumps_and_registers_are_recognised() {
        let jumps =
            [("bne.w    #0x8000410", Jump::Direct), ("pop      {r7, pc}", Jump::Indirect), ("bic r0, r1", Jump::None)];
        jumps.iter().for_each(|(text, jump)| assert_eq!(parsed(text).jump, *jump, "{text}"));
        let load = parsed("vldr     s20, [r6, #0x14]");
        assert_eq!((load.address_of, load.writes), (registers("r6"), registers("s20")));
        assert_eq!(parsed("push     {r7, lr}").address_of, registers("sp"));
        assert_eq!(parsed("ldm      r2!, {r0, r1}").address_of, registers("r2"));
        assert_eq!(parsed("vcmp.f32 s9, s4").writes, FLOAT_FLAGS);
        assert_eq!(parsed("ldr      r0, [pc, #0x38]").literal, Some(0x0800_013c));
    }
}
