//! The assignment problem: rows to columns at the least total cost.

/// Assigns each of `rows` rows a column of its own so that the summed cost is least: the Hungarian method as successive
/// shortest paths with dual prices, O(rows² · columns). Returns the column of each row.
///
/// # Panics
/// When there are fewer columns than rows.
pub(crate) fn assign(rows: usize, columns: usize, cost: impl Fn(usize, usize) -> f64) -> Vec<usize> {
    assert!(rows <= columns, "assign: {rows} rows need as many columns, not {columns}");
    const NONE: usize = usize::MAX;
    let mut row_price = vec![0.0; rows];
    let mut column_price = vec![0.0; columns];
    let mut row_of = vec![NONE; columns];
    for start in 0..rows {
        // Shortest path, in reduced costs, from the new row to a free column.
        let mut distance = vec![f64::INFINITY; columns];
        let mut from = vec![NONE; columns];
        let mut settled = vec![false; columns];
        let (mut row, mut at, mut reached) = (start, NONE, 0.0);
        let free = loop {
            let mut next = NONE;
            for column in (0..columns).filter(|&c| !settled[c]) {
                let through = reached + cost(row, column) - row_price[row] - column_price[column];
                if through < distance[column] {
                    distance[column] = through;
                    from[column] = at;
                }
                if next == NONE || distance[column] < distance[next] {
                    next = column;
                }
            }
            settled[next] = true;
            (at, reached) = (next, distance[next]);
            if row_of[next] == NONE {
                break next;
            }
            row = row_of[next];
        };
        row_price[start] += reached;
        for column in (0..columns).filter(|&c| settled[c] && c != free) {
            let gap = reached - distance[column];
            column_price[column] -= gap;
            row_price[row_of[column]] += gap;
        }
        // Augment: along the path every column passes to the row before it.
        let mut column = free;
        while from[column] != NONE {
            row_of[column] = row_of[from[column]];
            column = from[column];
        }
        row_of[column] = start;
    }
    let mut column_of = vec![NONE; rows];
    for (column, &row) in row_of.iter().enumerate() {
        if row != NONE {
            column_of[row] = column;
        }
    }
    column_of
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn least(rows: usize, columns: usize, cost: &[f64], row: usize, taken: &mut Vec<bool>) -> f64 {
        if row == rows {
            return 0.0;
        }
        let mut best = f64::INFINITY;
        for c in 0..columns {
            if !taken[c] {
                taken[c] = true;
                best = best.min(cost[row * columns + c] + least(rows, columns, cost, row + 1, taken));
                taken[c] = false;
            }
        }
        best
    }

    proptest! {
        #[test]
        fn nothing_costs_less(
            rows in 1usize..6,
            more in 0usize..3,
            cost in prop::collection::vec(0.0f64..10.0, 40),
        ) {
            let columns = rows + more;
            let got = assign(rows, columns, |r, c| cost[r * columns + c]);
            let mut used = got.clone();
            used.sort_unstable();
            used.dedup();
            prop_assert_eq!(used.len(), rows);
            let total: f64 = got.iter().enumerate().map(|(r, &c)| cost[r * columns + c]).sum();
            let least = least(rows, columns, &cost, 0, &mut vec![false; columns]);
            prop_assert!((total - least).abs() < 1e-9, "{} {}", total, least);
        }
    }
}
