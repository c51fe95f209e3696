//! What is printed: a table for a person, or lines of JSON for a program.

use super::Row;
use super::figures::{Built, Cost};
use super::instances::Field;

/// Prints rows as they come.
pub struct Report {
    json: bool,
}

impl Report {
    /// The head of the table.
    pub fn opening(json: bool, embree: Option<String>) -> Self {
        let peer =
            embree.map_or_else(|| "no peer: EMBREE_LIB is not set".to_owned(), |v| format!("Embree {v}"));
        let lines = [
            format!("rays: ns each on one thread: one ray a call, batch, Embree's best one-ray call; {peer}"),
            "builds: wall time on all threads, peak of the process; Embree: medium, high".to_owned(),
            format!(
                "{:>9} {:>21} {:>21} {:>16} {:>8} {:>8} {:>5}{}",
                "triangles",
                "build fast",
                "build high",
                "Embree's builds",
                "MiB",
                "nodes",
                "depth",
                ["primary", "bounce", "shadow"].map(|kind| format!("{kind:>20}")).concat()
            ),
        ];
        for line in lines {
            if json { eprintln!("{line}") } else { println!("{line}") }
        }
        Self { json }
    }

    /// One size.
    pub fn row(&self, row: &Row) {
        if self.json {
            println!("{}", row_line(row));
            return;
        }
        let embree = row
            .embree
            .map_or_else(|| "–".to_owned(), |e| format!("{}, {}", seconds(e.medium), seconds(e.high)));
        println!(
            "{:>9} {:>21} {:>21} {embree:>16} {:>8.1} {:>8} {:>5}{}",
            row.triangles,
            built(&row.fast),
            built(&row.high),
            mib(row.stats.bytes as u64),
            row.stats.nodes,
            row.stats.depth,
            costs(&row.costs),
        );
    }

    /// Instances.
    pub fn field(&self, field: &Field) {
        if self.json {
            println!("{}", field_line(field));
            return;
        }
        let (check, stats) = (&field.check, &field.stats);
        println!("\n{} instances of a mesh of {} triangles, in a room", field.instances, field.triangles);
        println!("  build   fast {}, high {}", built(&field.fast), built(&field.high));
        println!("  memory  {:.1} MiB, {} nodes", mib(stats.bytes as u64), stats.nodes);
        for c in &field.costs {
            let rate = |ns: f64| 1e3 / ns;
            println!(
                "  {:8}one {:.2}, batch {:.2} Mrays/s on one thread",
                c.kind.name(),
                rate(c.one),
                rate(c.batch)
            );
        }
        println!(
            "  check   {} hits repeated in the instance's space: {} differ in a bit; {} rays put to all instances: {} \
             answered otherwise",
            check.repeated, check.differing, check.exhaustive, check.wrong
        );
    }
}

fn mib(bytes: u64) -> f64 {
    bytes as f64 / 1_048_576.0
}

fn seconds(s: f64) -> String {
    if s < 0.1 { format!("{:.1} ms", s * 1e3) } else { format!("{s:.2} s") }
}

fn built(b: &Built) -> String {
    let peak = b.peak.map_or_else(|| "–".to_owned(), |p| format!("{:.0} MiB", mib(p)));
    format!("{}, {peak}", seconds(b.seconds))
}

fn costs(costs: &[Cost; 3]) -> String {
    let cell = |c: &Cost| {
        let embree = c.embree.map_or_else(|| "–".to_owned(), |ns| format!("{ns:.0}"));
        format!("{:>20}", format!("{:.0} {:.0} {embree}", c.one, c.batch))
    };
    costs.iter().map(cell).collect()
}

fn number(value: Option<f64>) -> String {
    value.filter(|v| v.is_finite()).map_or_else(|| "null".to_owned(), |v| format!("{v:.4}"))
}

fn build_members(name: &str, b: &Built) -> String {
    let peak = b.peak.map_or_else(|| "null".to_owned(), |p| p.to_string());
    format!(r#""build_{name}_s":{},"build_{name}_peak_bytes":{peak}"#, number(Some(b.seconds)))
}

fn cost_members(costs: &[Cost; 3]) -> String {
    let member = |c: &Cost| {
        let (one, batch, embree) = (number(Some(c.one)), number(Some(c.batch)), number(c.embree));
        format!(r#""{}_ns":{{"one":{one},"batch":{batch},"embree_best_one":{embree}}}"#, c.kind.name())
    };
    costs.iter().map(member).collect::<Vec<_>>().join(",")
}

fn row_line(row: &Row) -> String {
    let embree = |figure: fn(&super::EmbreeBuilt) -> f64| number(row.embree.as_ref().map(figure));
    format!(
        r#"{{"triangles":{},{},{},"embree_medium_s":{},"embree_high_s":{},"embree_bytes":{},"bytes":{},"nodes":{},"depth":{},"sah_cost":{},{}}}"#,
        row.triangles,
        build_members("fast", &row.fast),
        build_members("high", &row.high),
        embree(|e| e.medium),
        embree(|e| e.high),
        row.embree.map_or_else(|| "null".to_owned(), |e| e.bytes.to_string()),
        row.stats.bytes,
        row.stats.nodes,
        row.stats.depth,
        number(Some(row.stats.sah_cost)),
        cost_members(&row.costs),
    )
}

fn field_line(field: &Field) -> String {
    let check = &field.check;
    format!(
        r#"{{"instances":{},"triangles":{},{},{},"bytes":{},"nodes":{},"depth":{},{},"repeated":{},"differing":{},"exhaustive":{},"wrong":{}}}"#,
        field.instances,
        field.triangles,
        build_members("fast", &field.fast),
        build_members("high", &field.high),
        field.stats.bytes,
        field.stats.nodes,
        field.stats.depth,
        cost_members(&field.costs),
        check.repeated,
        check.differing,
        check.exhaustive,
        check.wrong,
    )
}
