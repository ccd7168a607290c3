//! Reads the driver's statistics of a pipeline: registers, spills and the size of subgroups.

use std::ffi::{CStr, FromBytesUntilNulError};

use ash::{khr, vk};

use crate::vulkan::VulkanError;

/// Executable that the driver made of a pipeline.
#[derive(Clone, Debug, PartialEq)]
pub struct Executable {
    /// Pass or shader of the pipeline.
    pub pipeline: String,
    /// Driver's name for the executable.
    pub name: String,
    /// Invocations of a subgroup.
    pub subgroup_size: u32,
    /// Statistics that the driver reports.
    pub statistics: Vec<Statistic>,
}

/// Number that a driver reports about an executable.
#[derive(Clone, Debug, PartialEq)]
pub struct Statistic {
    /// Name of the number, such as "Register Count".
    pub name: String,
    /// Meaning of the number, in the driver's words.
    pub description: String,
    /// Value of the number. A Boolean is 0 or 1.
    pub value: f64,
}

/// Reads the executables of `pipelines`, which are given with their names. The pipelines must have been
/// created with `CAPTURE_STATISTICS`, on a device with the feature `pipelineExecutableInfo`.
pub(crate) fn executables(
    loader: &khr::pipeline_executable_properties::Device,
    pipelines: &[(String, vk::Pipeline)],
) -> Result<Vec<Executable>, VulkanError> {
    let mut found = Vec::new();
    for (pipeline, handle) in pipelines {
        let info = vk::PipelineInfoKHR::default().pipeline(*handle);
        // SAFETY: the pipeline is alive and of this device.
        let properties = unsafe { loader.get_pipeline_executable_properties(&info) }
            .map_err(VulkanError::from_call("vkGetPipelineExecutablePropertiesKHR"))?;
        for (index, executable) in (0..).zip(&properties) {
            let info =
                vk::PipelineExecutableInfoKHR::default().pipeline(*handle).executable_index(index);
            // SAFETY: the pipeline has an executable with this number and captures statistics.
            let statistics = unsafe { loader.get_pipeline_executable_statistics(&info) }
                .map_err(VulkanError::from_call("vkGetPipelineExecutableStatisticsKHR"))?;
            found.push(Executable {
                pipeline: pipeline.clone(),
                name: text(executable.name_as_c_str()),
                subgroup_size: executable.subgroup_size,
                statistics: statistics.iter().map(Statistic::of).collect(),
            });
        }
    }
    Ok(found)
}

impl Statistic {
    fn of(raw: &vk::PipelineExecutableStatisticKHR) -> Self {
        use vk::PipelineExecutableStatisticFormatKHR as Format;
        // SAFETY: the driver has set the field that the format names, and every bit pattern is valid in each
        // of the fields.
        let value = unsafe {
            match raw.format {
                Format::BOOL32 => f64::from(raw.value.b32),
                Format::INT64 => raw.value.i64 as f64,
                Format::UINT64 => raw.value.u64 as f64,
                _ => raw.value.f64,
            }
        };
        let [name, description] = [raw.name_as_c_str(), raw.description_as_c_str()].map(text);
        Self { name, description, value }
    }
}

/// Returns the driver's text as an owned string, which is empty if the text has no end.
fn text(text: Result<&CStr, FromBytesUntilNulError>) -> String {
    text.unwrap_or_default().to_string_lossy().into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lavapipe, on which the tests usually run, lacks the extension. So the test fills the extension's
    /// structures as the specification says, and checks that they are read correctly.
    #[test]
    fn every_format_of_a_statistic_is_a_number() {
        use vk::PipelineExecutableStatisticFormatKHR as Format;
        use vk::PipelineExecutableStatisticValueKHR as Value;
        for (format, value, expected) in [
            (Format::BOOL32, Value { b32: 1 }, 1.0),
            (Format::INT64, Value { i64: -3 }, -3.0),
            (Format::UINT64, Value { u64: 64 }, 64.0),
            (Format::FLOAT64, Value { f64: 0.5 }, 0.5),
        ] {
            let mut raw =
                vk::PipelineExecutableStatisticKHR { format, value, ..Default::default() };
            for (to, from) in raw.name.iter_mut().zip(b"Register Count\0") {
                *to = *from as std::ffi::c_char;
            }
            let read = Statistic::of(&raw);
            assert_eq!((read.name.as_str(), read.value), ("Register Count", expected));
        }
    }
}
