//! Addresses of headers, root group and heap.

use super::heap::Heap;
use super::object::Messages;
use super::record::{Object, Property, describe};
use super::scales::Scales;

/// Addresses of headers, root group and heap.
#[derive(Debug)]
pub(super) struct Layout {
    objects: Vec<u64>,
    pub root: u64,
    heap: Vec<u64>,
}

impl Layout {
    /// Lengths do not depend on addresses: with none known, headers are as long as they will be.
    pub(super) fn of(
        objects: &[Object],
        scales: &Scales,
        root: &[(String, Property)],
        heap: &Heap,
        start: u64,
    ) -> Self {
        let mut unknown = Self {
            objects: vec![0; objects.len()],
            root: 0,
            heap: vec![0; heap.sizes().len()],
        };
        let mut at = start;
        let mut place = |bytes: usize| {
            let here = at;
            at = (at + bytes as u64).next_multiple_of(8);
            here
        };
        let headers = unknown.headers(objects, scales);
        let group = unknown.group(objects, root);
        let placed: Vec<u64> = headers.iter().map(|h| place(h.len())).collect();
        unknown.root = place(group.len());
        unknown.heap = heap.sizes().into_iter().map(place).collect();
        unknown.objects = placed;
        unknown
    }

    /// The parts of the file from the first header on.
    pub(super) fn encoded(
        &self,
        objects: &[Object],
        scales: &Scales,
        root: &[(String, Property)],
        heap: &mut Heap,
    ) -> Vec<Vec<u8>> {
        scales.refer(&self.objects, heap);
        let mut parts = self.headers(objects, scales);
        parts.push(self.group(objects, root));
        parts.extend(heap.encoded());
        parts
    }

    fn headers(&self, objects: &[Object], scales: &Scales) -> Vec<Vec<u8>> {
        let each = objects.iter().enumerate();
        each.map(|(k, object)| {
            let scale = scales.scale(k, &self.objects);
            let list = scales.list(k, &self.heap);
            object.header(scale.as_ref(), list, &self.heap)
        })
        .collect()
    }

    fn group(&self, objects: &[Object], root: &[(String, Property)]) -> Vec<u8> {
        let mut messages = Messages::default();
        messages.group(objects.len());
        for (order, object) in objects.iter().enumerate() {
            messages.link(order, &object.link, self.objects[order]);
        }
        describe(&mut messages, root, &self.heap);
        messages.header()
    }
}
